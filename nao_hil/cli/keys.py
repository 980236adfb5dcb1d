"""`nao-hil keys`: certificates for an encrypted link."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import msgspec
import typer
from rich.table import Table
from rich.text import Text

from bridge.errors import ConfigurationError
from bridge.link.certificates import ROLES
from nao_hil.cli.console import Answer, open_console


def keys(
    folder: Annotated[Path, typer.Argument(help="Folder of the authority and the certificates.")],
    host: Annotated[
        list[str] | None,
        typer.Option("--host", help="Name or address of the robot's machine; again for more.", metavar="HOST"),
    ] = None,
    days: Annotated[
        float, typer.Option("--days", help="Days until the certificates expire.", min=0.0, max=3650.0)
    ] = 365.0,
    role: Annotated[
        list[str] | None,
        typer.Option("--role", help="Only this role; again for more.", metavar="|".join(ROLES)),
    ] = None,
    renew: Annotated[
        bool, typer.Option("--renew", help="New certificates of the same authority for the ones there.")
    ] = False,
) -> Answer:
    """Make a certificate authority and a certificate for each role, or show the ones that are there.

    Example: nao-hil keys keys --host robot.local --days 90
    """
    from nao_hil.certificates import Keys

    if days <= 0.0:
        raise ConfigurationError("--days must be over 0: a certificate is good for some time.")
    for name in role or ():
        if name not in ROLES:
            raise ConfigurationError(f"No role {name!r}; known are {', '.join(ROLES)}.")
    authority = Keys(folder)
    wanted = [
        name for name in role or ROLES if renew or authority.made or (role and name not in authority.roles())
    ]
    for name in wanted:
        authority.issue(name, days, host or ())
    console = open_console()
    if not wanted:
        console.print("All of these are there already; --renew makes new ones of the same authority.")
    state = authority.state()
    table = Table("role", "expires (UTC)", "days left", "hosts", title=f"certificates in {folder}")
    for one in state:
        left = f"{one.days_left:.1f}" if one.days_left > 0.0 else Text("expired", "red")
        table.add_row(one.role, one.expires[:16].replace("T", " "), left, ", ".join(one.hosts))
    console.print(table)
    return Answer({"folder": str(folder), "made": wanted, "certificates": msgspec.to_builtins(state)})
