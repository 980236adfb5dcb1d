"""A script of a box in a program of its own: files are beside it, and behaviours are played."""

import os

from naoqi import ALProxy

frames = ALProxy("ALFrameManager", "nao.local", 9559)
folder = frames.getBehaviorPath(0)
print(os.path.basename(os.path.dirname(folder)), os.path.isfile(folder + "photos.py"))
number = frames.newBehaviorFromFile(folder + "../choregraphe/beep/behavior.xar", "root")
frames.playBehavior(number)
frames.completeBehavior(number)
for attempt in (
    frames.playFrames,
    lambda: frames.newBehaviorFromFile("/no.xar", ""),
    lambda: frames.exitBehavior(9),
):
    try:
        attempt()
    except RuntimeError as error:
        print(str(error)[:48])
