"""What the robot says of itself, its network, its users, and of who uses what."""

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
print(
    "users",
    ALProxy("ALUserSession", IP, PORT).getNumUsers(),
    ALProxy("ALUserSession", IP, PORT).getFocusedUser(),
)
diagnosis = ALProxy("ALDiagnosis", IP, PORT)
print("diagnosis", diagnosis.getActiveDiagnosis(), diagnosis.getPassiveDiagnosis())
print("launched", ALProxy("ALLauncher", IP, PORT).launchLocal("ALMotion"))
print("help", ALProxy("ALMotion", IP, PORT).getMethodHelp("setStiffnesses")[:2])
resources = ALProxy("ALResourceManager", IP, PORT)
resources.createResource("newResource", "")
print("free", resources.areResourcesFree(["newResource"]))
resources.acquireResource("newResource", "mine", "", 1)
print("free", resources.areResourcesFree(["newResource"]), resources.ownersGet())
resources.releaseResource("newResource", "mine")
resources.deleteResource("newResource")
voice = ALProxy("ALTextToSpeech", IP, PORT)
voice.setVoice(voice.getAvailableVoices()[-1])
print("voice", voice.getVoice() == voice.getAvailableVoices()[-1])
