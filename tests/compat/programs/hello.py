import sys

from naoqi import ALProxy

IP = sys.argv[1] if len(sys.argv) > 1 else "nao.local"
tts = ALProxy("ALTextToSpeech", IP, 9559)
tts.setLanguage("English")
tts.say("Hi")
print("said")
sys.exit(7)
