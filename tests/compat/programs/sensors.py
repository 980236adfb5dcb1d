# ruff: noqa: UP031
"""Extractors and keys of sensors: sonar, feet, inertial unit, battery, LEDs."""

from naoqi import ALProxy

memory, sonar = ALProxy("ALMemory", "nao.local", 9559), ALProxy("ALSonar", "nao.local", 9559)
sonar.subscribe("myApplication")
left = memory.getData("Device/SubDeviceList/US/Left/Sensor/Value")
sonar.unsubscribe("myApplication")
keys = [
    "Device/SubDeviceList/InertialSensor/AngleX/Sensor/Value",
    "Device/SubDeviceList/LFoot/FSR/TotalWeight/Sensor/Value",
    "Device/SubDeviceList/Battery/Charge/Sensor/Value",
    "Nothing",
]
values = memory.getListData(keys)
print("sonar %.1f" % left, "weight %.1f" % values[1], values[3])
print("battery", ALProxy("ALBattery", "nao.local", 9559).getBatteryCharge())
leds = ALProxy("ALLeds", "nao.local", 9559)
leds.fadeRGB("FaceLeds", 0x00FF0000, 0.1)
print("red %.1f" % leds.getIntensity("RightFaceLedsRed"))
leds.post.rotateEyes(0x0000FF, 0.5, 0.5)
