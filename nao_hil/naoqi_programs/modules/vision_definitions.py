# ruff: noqa: N816  the vendor's names
"""The module `vision_definitions` of the vendor's Python SDK: numbers of cameras and settings."""

kTopCamera, kBottomCamera = 0, 1
kQQVGA, kQVGA, kVGA, k4VGA, k16VGA, kQQQVGA, kQQQQVGA = 0, 1, 2, 3, 4, 7, 8
kYuvColorSpace, kYUV422ColorSpace, kYUVColorSpace = 0, 9, 10
kRGBColorSpace, kHSYColorSpace, kBGRColorSpace = 11, 12, 13
kYColorSpace = 0
kCameraBrightnessID, kCameraContrastID, kCameraSaturationID, kCameraHueID = 0, 1, 2, 3
kCameraGainID, kCameraHFlipID, kCameraVFlipID = 6, 7, 8
kCameraAutoExpositionID, kCameraAutoWhiteBalanceID = 11, 12
kCameraExposureID, kCameraSharpnessID = 17, 24
