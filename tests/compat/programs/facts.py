"""Facts about the robot and its network; a service that is not offered is refused."""

import xml.etree.ElementTree as ElementTree

from naoqi import ALProxy

IP, PORT = "nao.local", 9559
system = ALProxy("ALSystem", IP, PORT)
print("memory", 0 < system.freeMemory() <= system.totalMemory(), len(system.diskFree(True)))
model = ALProxy("ALRobotModel", IP, PORT)
values = {p.get("memoryName"): p.get("value") for p in ElementTree.fromstring(model.getConfig())}
print("body", values["RobotConfig/Body/Type"], values == model.getConfigMap())
network = ALProxy("ALConnectionManager", IP, PORT)
network.scan()
print("network", network.state(), [dict(s)["Name"] for s in network.services()], network.technologies())
print("help", ALProxy("ALMotion", IP, PORT).getMethodHelp("setStiffnesses")[:2])
voice = ALProxy("ALTextToSpeech", IP, PORT)
voice.setVoice(voice.getAvailableVoices()[-1])
print("voice", voice.getVoice() == voice.getAvailableVoices()[-1])
try:
    ALProxy("ALUserSession", IP, PORT)
except RuntimeError as error:
    print("refused", "nao-hil does not offer it" in str(error), "ALMotion" in str(error))
