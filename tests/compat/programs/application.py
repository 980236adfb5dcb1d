"""A qi application whose robot's address is on the command line."""

import sys

import qi

app = qi.Application(["Program", "--qi-url=tcp://nao.local:9559"])
app.start()
session = app.session
memory = session.service("ALMemory")
memory.insertData("Mine", [1, "two", 3.0])
print("data", memory.getData("Mine"))
print("life", session.service("ALAutonomousLife").getState())
sys.exit("ends with a word")
