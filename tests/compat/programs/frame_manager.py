"""A script of a box in a program of its own: files are beside it."""

import os

from naoqi import ALProxy

frames = ALProxy("ALFrameManager", "nao.local", 9559)
folder = frames.getBehaviorPath(0)
print(os.path.basename(os.path.dirname(folder)), os.path.isfile(folder + "photos.py"))
try:
    frames.playFrames()
except RuntimeError as error:
    print(str(error).partition(";")[0])
