"""MuJoCo behind the interface of `emulator.engine.base`."""
