"""Modules that see and hear, on a robot that nobody meets or talks to; and a compass."""

import time

import qi

app = qi.Application(["quiet", "--qi-url=tcp://nao.local:9559"])
app.start()
session = app.session
memory = session.service("ALMemory")
for name, event in (
    ("ALDarknessDetection", "DarknessDetection/DarknessDetected"),
    ("ALBarcodeReader", "BarcodeReader/BarcodeDetected"),
    ("ALMovementDetection", "MovementDetection/MovementDetected"),
    ("ALSoundDetection", "SoundDetected"),
):
    service = session.service(name)
    if name == "ALSoundDetection":
        service.setParameter("Sensitivity", 0.3)
    else:
        service.setActiveCamera(1)
        service.setFrameRate(10)
    service.subscribe("me", 500, 0.0)
    print(name, memory.getData(event), service.getSubscribersInfo()[0][0])
    service.unsubscribe("me")

dialog = session.service("ALDialog")
dialog.setLanguage("English")
topic = dialog.loadTopicContent("topic: ~greeting()\nlanguage: enu\nu: (hello) hello to you\n")
dialog.subscribe("me")
dialog.activateTopic(topic)
print("topics", dialog.getActivatedTopics(), dialog.getLoadedTopics("English"))
dialog.unsubscribe("me")
dialog.deactivateTopic(topic)
dialog.unloadTopic(topic)

compass = session.service("ALVisualCompass")
compass.enableReferenceRefresh(True)
compass.subscribe("me")
for _ in range(3000):  # until it has its picture of before the turn
    try:
        memory.getData("VisualCompass/Deviation")
        break
    except RuntimeError:  # none has come
        time.sleep(0.05)
session.service("ALMotion").angleInterpolation("HeadYaw", 0.3, 1.0, False)
deviation = []
for _ in range(3000):
    deviation = memory.getData("VisualCompass/Deviation")
    if deviation and abs(deviation[0][1] - 0.3) < 0.02:
        break
    time.sleep(0.05)
print("turned", abs(deviation[0][1] - 0.3) < 0.02, len(deviation[1]), len(deviation[2]))
compass.unsubscribe("me")
