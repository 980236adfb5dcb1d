"""The cameras of one robot: `python -m emulator.camera ROBOT ENDPOINT DESCRIPTOR`.

Started by `bridge.adapters.naoqi.core.cameras`, which has the messages.
"""

import os
import sys

if __name__ == "__main__":
    # Before numpy is imported: its threads would take the robot's processor.
    os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"
    from bridge.realtime import leave_real_time

    leave_real_time()  # the serving process hands its priority on, and a picture would hold up the walker
    os.nice(10)
    from emulator.camera.process import main

    main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
