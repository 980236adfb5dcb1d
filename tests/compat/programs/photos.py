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
for seconds in (1.0, 60.0):  # a machine that has no time for it takes fewer pictures
    recorder.startRecording(FOLDER, "film")
    records = recorder.isRecording()
    time.sleep(seconds)
    count, path = recorder.stopRecording()
    if count > 1:
        break
print("records", records)
with open(path, "rb") as film:
    print("film", path.split("/")[-1], count > 1, film.read(12)[::8])
