"""What a program can do wrong, and the sentences it gets."""

from naoqi import ALProxy

for attempt in (
    lambda: ALProxy("ALNothing", "nao.local", 9559),
    lambda: ALProxy("ALMotion", "nao.local", 9559).setAngels("HeadYaw", 0.0, 0.1),
    lambda: ALProxy("ALMotion", "nao.local", 9559).animation(),
    lambda: ALProxy("ALMotion", "nao.local", 9559).setAngles("Nose", 0.0, 0.1),
    lambda: ALProxy("ALMemory", "nao.local", 9559).getData("Nothing"),
    lambda: ALProxy("ALBehaviorManager", "nao.local", 9559).runBehavior("dance"),
):
    try:
        attempt()
    except RuntimeError as error:
        print(str(error).splitlines()[0][:60])
raise ValueError("the program's own")
