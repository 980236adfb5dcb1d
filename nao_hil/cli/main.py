"""`nao-hil`: the command line of both sides.

Exit codes: 0 done and well, 1 the robot fell or a verdict failed, 2 usage or configuration, 3 a process, a
link or a device failed; 130 interrupted.
"""

from __future__ import annotations

import contextlib
import errno
import os
import re
import sys
import traceback
from typing import Annotated, Any

import typer

from bridge.errors import NaoHilError
from nao_hil import __version__
from nao_hil.cli import (
    campaign,
    catalogue,
    compare,
    config,
    demo,
    design,
    doctor,
    drive,
    emulate,
    excite,
    experiment,
    export,
    export_run,
    guard,
    identify,
    info,
    keys,
    lola,
    map,
    motion,
    naoqi,
    plan,
    plot,
    record,
    replay,
    results,
    run_choregraphe,
    run_naoqi,
    tune,
    up,
    view,
    walk,
    world,
)
from nao_hil.cli.certificates import add_keys
from nao_hil.cli.logs import end_log

_ClickException: Any = typer.BadParameter.__mro__[2]
"""Base of all errors of usage; typer may carry a copy of click of its own, or use the installed one."""

app = typer.Typer(
    name="nao-hil",
    help="An emulator of the humanoid robot NAO, and a walking controller for it.",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command()(demo.demo)
app.command()(up.up)
app.command()(emulate.emulate)
app.command()(walk.walk)
app.command()(drive.drive)
app.command()(view.view)
app.command()(record.record)
app.command()(replay.replay)
app.command()(info.info)
app.command()(plot.plot)
app.command()(compare.compare)
app.command()(excite.excite)
app.command()(identify.identify)
app.command()(doctor.doctor)
app.command()(plan.plan)
app.command("run-naoqi", context_settings={"allow_interspersed_args": False})(run_naoqi.run_naoqi)
app.command("run-choregraphe")(run_choregraphe.run_choregraphe)
app.command()(motion.motion)
app.command()(experiment.experiment)
app.command()(campaign.campaign)
app.command("map")(map.map_)
app.command()(tune.tune)
app.command()(results.results)
app.command()(catalogue.robots)
app.command()(catalogue.gaits)
app.command()(experiment.experiments)
app.command()(catalogue.scenarios)
app.command()(guard.stop)
app.command()(guard.arm)
app.command()(keys.keys)
serve = typer.Typer(
    help="Let a robot on the link pose as a NAO for programs written for one.", no_args_is_help=True
)
serve.command("lola")(lola.serve)
serve.command("naoqi")(naoqi.serve)
app.add_typer(serve, name="serve")
bridge = typer.Typer(help="Put a real NAO on the link.", no_args_is_help=True)
bridge.command("lola")(lola.bridge)
bridge.command("naoqi")(naoqi.bridge)
app.add_typer(bridge, name="bridge")
designs = typer.Typer(help="Compute the numbers that the walker and the robot load.", no_args_is_help=True)
designs.command("torso")(design.torso)
designs.command("ensemble")(design.ensemble)
app.add_typer(designs, name="design")
worlds = typer.Typer(
    help="Put a ball, landmarks and faces before the cameras of an emulated robot.", no_args_is_help=True
)
worlds.command("ball")(world.ball)
worlds.command("landmark")(world.landmark)
worlds.command("face")(world.face)
worlds.command("remove")(world.remove)
worlds.command("list")(world.show)
app.add_typer(worlds, name="world")
exports = typer.Typer(
    cls=export_run.RunUnlessNamed,
    help="Write a recorded run as a page or a video, or the calibrated robot for other simulators.",
    no_args_is_help=True,
)
exports.command("run")(export_run.export_run)
exports.command("mjcf")(export.mjcf)
exports.command("urdf")(export.urdf)
app.add_typer(exports, name="export")
configuration = typer.Typer(help="Show or check the configuration of a run.", no_args_is_help=True)
configuration.command("show")(config.show)
configuration.command("check")(config.check)
app.add_typer(configuration, name="config")
add_keys(app)  # after all commands


def _version(value: bool) -> None:
    if value:
        typer.echo(f"nao-hil {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    pass


def main(arguments: list[str] | None = None) -> None:
    """Entry point: every error a user can cause is one sentence on stderr and an exit code."""
    code = run(arguments)
    end_log()
    for stream in (sys.stdout, sys.stderr):
        if stream is None:  # closed by whoever started this
            continue
        try:
            stream.flush()
        except BrokenPipeError:  # `| head` has read enough
            pass
        except OSError as error:
            code = _unwritten(error)
    # Everything that must be closed is; Python taking its libraries apart would double the time a Ctrl-C takes.
    os._exit(code)


def run(arguments: list[str] | None = None) -> int:
    """As `main`, but the exit code is returned."""
    try:
        result: Any = app(args=arguments, standalone_mode=False)
    except _ClickException as error:
        # A command without arguments has shown its help instead.
        if sentence := _in_words(error.format_message()):
            many = getattr(getattr(error, "param", None), "nargs", 1)
            _tell(f"{sentence}; it takes {many} of them" if many > 1 else sentence)
        return 2
    except NaoHilError as error:
        _tell(str(error))
        return error.exit_code
    except (KeyboardInterrupt, typer.Abort):
        return 130
    except SystemExit:  # typer's way to end when `| head` has read enough; its exit code would be a fall's
        return 0
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT):
            return _fault(error)
        return _unwritten(error)
    except Exception as error:  # not to be taken for a fall, whose exit code Python's own would be
        return _fault(error)
    return result if isinstance(result, int) else 0


def _in_words(sentence: str) -> str:
    """Typer's sentence as a person would say it."""
    sentence = re.sub(r"Input should be a valid integer\b.*", "it must be a whole number", sentence)
    sentence = re.sub(r"Input should be a valid number\b.*", "it must be a number", sentence)
    return sentence.replace("Input should be ", "it must be ")


def _unwritten(error: OSError) -> int:
    _tell(f"nothing more can be written ({error.strerror}); make room, or write elsewhere.")
    return 3


def _fault(error: Exception) -> int:
    traceback.print_exc()
    _tell(f"this is a fault of nao-hil itself: {error!r}; please report it.")
    return 3


def _tell(sentence: str) -> None:
    end_log()
    with contextlib.suppress(OSError):
        print(f"error: {sentence}", file=sys.stderr)
