"""A module of the program's own that ALMemory calls for an event, with a global broker."""

import sys
import time

from naoqi import ALBroker, ALModule, ALProxy

ReactToTouch = None
memory = None


class ReactToTouchModule(ALModule):
    def __init__(self, name):
        ALModule.__init__(self, name)
        self.count = 0
        global memory
        memory = ALProxy("ALMemory")
        memory.subscribeToEvent("FrontTactilTouched", "ReactToTouch", "onTouched")

    def onTouched(self, key, value):
        memory.unsubscribeToEvent("FrontTactilTouched", "ReactToTouch")
        print("touched", key, value)
        self.count += 1


def main():
    broker = ALBroker("myBroker", "0.0.0.0", 0, "nao.local", 9559)
    global ReactToTouch
    ReactToTouch = ReactToTouchModule("ReactToTouch")
    memory.raiseEvent("FrontTactilTouched", 1.0)
    for _ in range(3000):
        if ReactToTouch.count:
            break
        time.sleep(0.05)
    memory.raiseEvent("FrontTactilTouched", 0.0)
    print("subscribers", memory.getSubscribers("FrontTactilTouched"))
    broker.shutdown()
    sys.exit(0)


if __name__ == "__main__":
    main()
