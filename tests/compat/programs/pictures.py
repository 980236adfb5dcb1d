"""A picture of the bottom camera, as programs take it: with naoqi and with qi."""

import qi
import vision_definitions
from naoqi import ALProxy

IP, PORT = "nao.local", 9559
video = ALProxy("ALVideoDevice", IP, PORT)
video.setActiveCamera(vision_definitions.kBottomCamera)
client = video.subscribe("python_client", vision_definitions.kQVGA, vision_definitions.kRGBColorSpace, 5)
image = video.getImageRemote(client)
width, height, layers = image[0], image[1], image[2]
array = image[6]
print("size", width, height, layers, "of", len(array), "camera", image[7])
video.releaseImage(client)
print("gone", video.unsubscribe(client), video.unsubscribe(client))

session = qi.Session()
session.connect("tcp://" + IP + ":" + str(PORT))
device = session.service("ALVideoDevice")
handle = device.subscribeCamera("grey", 0, vision_definitions.kQQVGA, 0, 15)
grey = device.getImageRemote(handle)
print("grey", len(bytes(grey[6])), "angles", [round(a, 2) for a in grey[8:]])
print("red", max(array[0::3]) > 200, min(array[1::3]) < 60)
device.unsubscribe(handle)
