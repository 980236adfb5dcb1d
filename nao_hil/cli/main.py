"""`nao-hil`: the command line of both sides.

Exit codes: 0 done and well, 1 the robot fell or a verdict failed, 2 usage or configuration, 3 a process, a
link or a device failed; 130 interrupted.
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
import traceback
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, Final

import typer
from typer.core import TyperCommand, TyperGroup

from bridge.errors import ConfigurationError, NaoHilError
from bridge.validation import unknown_name
from nao_hil import __version__
from nao_hil.cli.added_options import with_shared_options
from nao_hil.cli.console import end_log, printable
from nao_hil.cli.signals import loading
from nao_hil.files import DISK_FULL_ERRORS

_ClickException: Any = typer.BadParameter.__mro__[2]
"""Base of all errors of usage; typer may carry a copy of click of its own, or use the installed one."""

PANELS: Final = {
    "Start": ("demo", "up", "emulate", "walk", "drive", "view", "doctor"),
    "Robots and programs": ("serve", "bridge", "ros", "run-naoqi", "run-choregraphe", "motion", "world"),
    "Safety": ("stop", "arm", "keys"),
    "Recordings": ("record", "replay", "info", "plot", "diff", "export"),
    "Experiments": ("experiment", "experiments", "campaign", "map", "results", "tune"),
    "Models": ("compare", "excite", "identify", "plan", "design"),
    "Names and configuration": ("robots", "gaits", "scenarios", "config"),
}
"""Heading of the help -> commands and groups under it."""
ELSEWHERE: Final = {
    "demo": "up:demo",
    "record": "recordings:record",
    "replay": "recordings:replay",
    "info": "recordings:info",
    "compare": "identify:compare",
    "excite": "identify:excite",
    "run-choregraphe": "run_naoqi:run_choregraphe",
    "map": "campaign:map_",
    "results": "campaign:results",
    "robots": "config:robots",
    "gaits": "config:gaits",
    "experiments": "experiment:experiments",
    "scenarios": "config:scenarios",
    "stop": "guard:stop",
    "arm": "guard:arm",
}
"""Command -> module of this package and function in it; of the others both have the command's name."""
GROUPS: Final = {
    "serve": (
        "Let a robot on the link pose as a NAO for programs written for one, and for a GameController.",
        {
            "lola": "adapters:serve_lola",
            "naoqi": "adapters:serve_naoqi",
            "gamecontroller": "adapters:serve_gamecontroller",
        },
    ),
    "bridge": (
        "Put a real NAO on the link.",
        {"lola": "adapters:bridge_lola", "naoqi": "adapters:bridge_naoqi"},
    ),
    "design": (
        "Compute the numbers that the walker and the robot load.",
        {"torso": "design:torso"},
    ),
    "world": (
        "Put things before the cameras of an emulated robot, press its buttons, reset it.",
        {
            "place": "world:place",
            "red-ball": "world:red_ball",
            "landmark": "world:landmark",
            "face": "world:face",
            "remove": "world:remove",
            "press": "world:press",
            "reset": "world:reset",
            "list": "world:show",
        },
    ),
    "export": (
        "Write a recorded run as a page, a video or a ROS bag, or the calibrated robot for other simulators.",
        {
            "run": "export:export_run",
            "rosbag": "ros:rosbag",
            "mjcf": "export:mjcf",
            "urdf": "export:urdf",
            "folder": "export:folder",
        },
    ),
    "config": (
        "Show or check the configuration of a run.",
        {"show": "config:show", "check": "config:check"},
    ),
}
"""Group -> its help and its commands."""


class _RunUnlessNamed(TyperGroup):
    """`nao-hil export RUN ...` means `nao-hil export run RUN ...`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Insert the name of the default command where none is given.

        Raises:
            ConfigurationError: the argument is neither a command nor a path.
        """
        named = not args or args[0] in self.commands or args[0].startswith("-")
        path = Path(args[0]) if args else Path()
        if not named and path.name == args[0] and path.suffix != ".mcap" and not path.exists():
            known = unknown_name("export", args[0], self.commands)
            raise ConfigurationError(f"{known}, or a recording or a run's folder; --robot takes a body")
        return super().parse_args(ctx, args if named else ["run", *args])


def _version(value: bool) -> None:
    if value:
        typer.echo(f"nao-hil {__version__}")
        raise typer.Exit


def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    pass


def _application(arguments: list[str]) -> typer.Typer:
    """The command line as far as these arguments need it: one command or group, or all of them for the help.

    To load all modules and to build all options takes longer than most commands take to answer.
    """
    app = typer.Typer(
        name="nao-hil",
        help="An emulator of the humanoid robot NAO, and a walking controller for it.",
        no_args_is_help=True,
        rich_markup_mode="rich",
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
        callback=_options,
    )
    panels = {name: panel for panel, names in PANELS.items() for name in names}
    names = [*panels]
    for name in arguments[:1] if arguments[:1] and arguments[0] in names else names:
        if name not in GROUPS:
            own = name.replace("-", "_")
            _add(app, name, ELSEWHERE.get(name, f"{own}:{own}"), panels[name])
            continue
        text, commands = GROUPS[name]
        group = typer.Typer(
            cls=_RunUnlessNamed if name == "export" else TyperGroup, help=text, no_args_is_help=True
        )
        for command, place in commands.items():
            _add(group, command, place)
        app.add_typer(group, name=name, rich_help_panel=panels[name])
    return app


class _NegativeNumbers(TyperCommand):
    """A command whose arguments may be negative numbers, as a coordinate is."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        known = {option for each in self.params for option in (*each.opts, *each.secondary_opts)}
        unknown = {arg for arg in args if arg.startswith("-") and arg.partition("=")[0] not in known}
        numbers = set(filter(_is_number, unknown))
        if ctx.allow_interspersed_args and numbers:
            ctx.ignore_unknown_options = numbers == unknown
            if numbers != unknown:  # so that the option at fault is named, and not a number
                args = ["0" if arg in numbers else arg for arg in args]
        return super().parse_args(ctx, args)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _add(app: typer.Typer, name: str, place: str, panel: str | None = None) -> None:
    module, _, function = place.partition(":")
    run = with_shared_options(getattr(import_module(f"nao_hil.cli.{module}"), function))
    settings = {"allow_interspersed_args": name != "run-naoqi"}
    app.command(name, cls=_NegativeNumbers, context_settings=settings, rich_help_panel=panel)(run)


def main(arguments: list[str] | None = None, interrupt: Any = None) -> None:
    """Entry point: every error a user can cause is one sentence on stderr and an exit code.

    Args:
        arguments: None: those of the process.
        interrupt: Handler of SIGINT once the command is loaded; None: the present one.
    """
    code = run(arguments, interrupt)
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


def run(arguments: list[str] | None = None, interrupt: Any = None) -> int:
    """As `main`, but the exit code is returned."""
    arguments = sys.argv[1:] if arguments is None else arguments
    try:
        with loading(interrupt):
            application = _application(arguments)
        result: Any = application(args=arguments, standalone_mode=False)
    except _ClickException as error:
        # A command without arguments has shown its help instead.
        if sentence := _in_words(error.format_message(), error.ctx):
            many = getattr(getattr(error, "param", None), "nargs", 1)
            _print_error(f"{sentence}; it takes {many} of them" if many > 1 else sentence)
        return 2
    except NaoHilError as error:
        _print_error(str(error))
        return error.exit_code
    except (KeyboardInterrupt, typer.Abort):
        return 130
    except SystemExit:  # typer's way to end when `| head` has read enough; its exit code would be a fall's
        return 0
    except OSError as error:
        if error.errno not in DISK_FULL_ERRORS:
            return _fault(error)
        return _unwritten(error)
    except Exception as error:  # not to be taken for a fall, whose exit code Python's own would be
        return _fault(error)
    return result if isinstance(result, int) else 0


def _in_words(sentence: str, context: Any) -> str:
    """Typer's message about a command, in plain words."""
    if found := re.fullmatch(r"Got unexpected extra arguments?(?:\(s\))? \((.*)\)", sentence):
        options = [option for each in context.command.params for option in each.opts if option.startswith("--")]
        return f"{found[1]!r} needs an option before it; {context.command_path} has {', '.join(options)}"
    sentence = re.sub(r"Input should be a valid integer\b.*", "it must be a whole number", sentence)
    sentence = re.sub(r"Input should be a valid number\b.*", "it must be a number", sentence)
    return sentence.replace("Input should be ", "it must be ")


def _unwritten(error: OSError) -> int:
    _print_error(f"nothing more can be written ({error.strerror}); make room, or write elsewhere.")
    return 3


def _fault(error: Exception) -> int:
    traceback.print_exc()
    _print_error(f"this is a fault of nao-hil itself: {error!r}; please report it.")
    return 3


def _print_error(sentence: str) -> None:
    end_log()
    with contextlib.suppress(OSError):
        print(f"error: {printable(sentence)}", file=sys.stderr)
