# ruff: noqa: N816  the vendor's names
"""The module `vision_definitions` of the vendor's Python SDK: numbers of cameras and settings."""

kTopCamera, kBottomCamera, kDepthCamera = 0, 1, 2
kOV7670, kMT9M114 = 1, 2
kQQVGA, kQVGA, kVGA, k4VGA, k16VGA, kQQQVGA, kQQQQVGA = 0, 1, 2, 3, 4, 7, 8
kYuvColorSpace, kyUvColorSpace, kyuVColorSpace = 0, 1, 2
kYColorSpace, kUColorSpace, kVColorSpace = 0, 1, 2
kRgbColorSpace, krGbColorSpace, krgBColorSpace = 3, 4, 5
kRColorSpace, kGColorSpace, kBColorSpace = 3, 4, 5
kHsyColorSpace, khSyColorSpace, khsYColorSpace = 6, 7, 8
kHColorSpace, kSColorSpace, kYUV422InterlacedColorSpace = 6, 7, 9
kYUV422ColorSpace, kYUVColorSpace, kRGBColorSpace, kHSYColorSpace, kHSVColorSpace = 9, 10, 11, 12, 12
kBGRColorSpace, kYYCbCrColorSpace, kH2RGBColorSpace, kHSMixedColorSpace = 13, 14, 15, 16
kDepthColorSpace, kARGBColorSpace, kXYZColorSpace, kInfraredColorSpace = 17, 18, 19, 20
kDistanceColorSpace, kRawDepthColorSpace = 21, 23
kSimpleScaleMethod, kAverageScaleMethod, kQualityScaleMethod, kNoScaling = 0, 1, 2, 3
kCameraBrightnessID, kCameraContrastID, kCameraSaturationID, kCameraHueID = 0, 1, 2, 3
kCameraRedChromaID, kCameraBlueChromaID, kCameraGainID = 4, 5, 6
kCameraHFlipID, kCameraVFlipID, kCameraLensXID, kCameraLensYID = 7, 8, 9, 10
kCameraAutoExpositionID, kCameraAutoWhiteBalanceID, kCameraAutoGainID = 11, 12, 13
kCameraResolutionID, kCameraFrameRateID, kCameraBufferSizeID = 14, 15, 16
kCameraExposureID, kCameraSelectID, kCameraSetDefaultParamsID, kCameraColorSpaceID = 17, 18, 19, 20
kCameraExposureCorrectionID, kCameraExposureAlgorithmID, kCameraAecAlgorithmID = 21, 22, 22
kCameraFastSwitchID, kCameraSharpnessID, kCameraAwbGreenGainID = 23, 24, 25
kCameraAblcID, kCameraAblcTargetID, kCameraAblcStableRangeID = 26, 27, 28
kCameraBlcBlueID, kCameraBlcRedID, kCameraBlcGbID, kCameraBlcGrID = 29, 30, 31, 32
kCameraWhiteBalanceID, kCameraBacklightCompensationID, kCameraKeepAliveID = 33, 34, 35
kCameraDepthConfidenceThresholdID, kCameraDepthFastFilterID, kCameraTemperatureID = 36, 37, 38
kCameraAverageLuminanceID, kCameraAutoFocusID = 39, 40
