"""A module whose callback fails, and subscriptions that nobody could answer."""

import time

from naoqi import ALBroker, ALModule, ALProxy


def helper(value):
    raise ValueError(f"no {value}")


class Faulty(ALModule):
    called = False

    def onEvent(self, name, value, message):
        self.called = True
        helper(value)


broker = ALBroker("broker", "0.0.0.0", 0, "nao.local", 9559)
faulty = Faulty("Faulty")
memory = ALProxy("ALMemory")
for subscribe, module, method in [
    (memory.subscribeToEvent, "Faulty", "noSuchMethod"),
    (memory.subscribeToMicroEvent, "nobody", "onEvent"),
]:
    try:
        subscribe("MyEvent", module, method)
        print(module, "is taken")
    except RuntimeError as error:
        print(error)
memory.subscribeToEvent("MyEvent", "ALTextToSpeech", "say")
print("the robot's own", "ALTextToSpeech" in memory.getSubscribers("MyEvent"))
memory.unsubscribeToEvent("MyEvent", "ALTextToSpeech")
memory.subscribeToEvent("MyEvent", "Faulty", "onEvent")
memory.raiseEvent("MyEvent", 3)
for _ in range(3000):
    if faulty.called:
        break
    time.sleep(0.05)
time.sleep(2.0)  # in which the error is told
