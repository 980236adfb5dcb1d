"""Photos and a film of the cameras, kept on the robot."""

import time

from naoqi import ALProxy

IP, PORT = "nao.local", 9559
FOLDER = "/home/nao/recordings/cameras/"
photos = ALProxy("ALPhotoCapture", IP, PORT)
photos.setResolution(1)
photos.setPictureFormat("jpg")
photos.setCameraID(1)
names = photos.takePictures(2, FOLDER, "image")[0]
print("names", [name.split("/")[-1] for name in names])
print("one", photos.takePicture(FOLDER, "single")[0].split("/")[-1])

from PIL import Image  # noqa: E402

picture = Image.open(names[1])
print("picture", picture.format, picture.size, len(set(picture.tobytes())) > 10)

recorder = ALProxy("ALVideoRecorder", IP, PORT)
recorder.setResolution(0)
recorder.setFrameRate(10)
recorder.setVideoFormat("MJPG")
recorder.startRecording(FOLDER, "film")
print("records", recorder.isRecording())
time.sleep(1.0)
count, path = recorder.stopRecording()
with open(path, "rb") as film:
    print("film", path.split("/")[-1], count > 1, film.read(12)[::8])
