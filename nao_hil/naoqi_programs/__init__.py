"""Programs written for NAOqi, run unchanged: `nao-hil run-naoqi`.

`modules` has the modules that such programs import, `runner` runs one by `loading`, `source` detects Python 2.
"""
