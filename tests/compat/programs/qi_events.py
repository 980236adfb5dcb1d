"""A class that holds a subscriber's signal, with qi and argparse."""

import argparse
import sys
import time

import qi


class Listener:
    def __init__(self, session):
        self.memory = session.service("ALMemory")
        self.heard = []
        self.subscriber = self.memory.subscriber("WordRecognized")
        self.link = self.subscriber.signal.connect(self.on_word)
        self.speech = session.service("ALSpeechRecognition")
        self.speech.pause(True)
        self.speech.setLanguage("English")
        self.speech.setVocabulary(["yes", "no"], False)
        self.speech.pause(False)
        self.speech.subscribe("Listener")

    def on_word(self, value):
        self.heard.append(value[0])


def main(session):
    listener = Listener(session)
    session.service("NaoHil").hear("yes")
    for _ in range(3000):
        if listener.heard:
            break
        time.sleep(0.05)
    print("heard", listener.heard)
    listener.speech.unsubscribe("Listener")
    listener.subscriber.signal.disconnect(listener.link)
    future = session.service("ALTextToSpeech").say("ok", _async=True)
    future.wait()
    print("said", future.hasError())


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", type=str, default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    args = parser.parse_args()
    session = qi.Session()
    try:
        session.connect("tcp://" + args.ip + ":" + str(args.port))
    except RuntimeError:
        print("Can't connect to Naoqi at ip \"" + args.ip + '".')
        sys.exit(1)
    main(session)
