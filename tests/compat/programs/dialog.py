"""A dialogue of a topic, as the vendor's tutorial has one."""

import qi

TOPIC = """topic: ~greeting()
language: enu
concept:(hello) ["good morning" hello hi]
u: (~hello {robot} my name is _*) $visitor=$1 Hello $1 , nice to meet you
    u1: (thank you) What about you?
u: (are you well) Yes
u: (play) Fine. ^goto(ages)
proposal: %ages How old are you?
    u1: (seven) So am I
"""

session = qi.Session()
session.connect("tcp://nao.local:9559")
dialog, memory = session.service("ALDialog"), session.service("ALMemory")
dialog.setLanguage("English")
topic = dialog.loadTopicContent(TOPIC)
print("topic", topic)
dialog.activateTopic(topic)
dialog.subscribe("my_dialog")
try:
    dialog.forceInput("Good morning robot, my name is Anna")
    print("answer", memory.getData("Dialog/LastAnswer"))
    dialog.forceInput("thank you")
    print("again", memory.getData("Dialog/LastAnswer"))
    print("variable", memory.getData("visitor"))
    session.service("NaoHil").hear("Are you well?")
    print("heard", memory.getData("Dialog/LastAnswer"))
    dialog.forceInput("play")
    dialog.forceInput("seven")
    print("jumped", memory.getData("Dialog/LastAnswer"))
    dialog.forceInput("what")
    print("not understood", memory.getData("Dialog/NotUnderstood"))
finally:
    dialog.unsubscribe("my_dialog")
    dialog.deactivateTopic(topic)
    dialog.unloadTopic(topic)
