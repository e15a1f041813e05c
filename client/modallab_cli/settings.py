"""Settings of the service, from options of a command and the environment."""

from typing import Any

import click


def settings_of(**overrides: Any) -> Any:
    """Return the settings of the environment; options that are not None go before."""
    from pydantic import ValidationError

    from modallab.api.settings import ServiceSettings

    try:
        return ServiceSettings(**{name: value for name, value in overrides.items() if value is not None})
    except ValidationError as error:
        fault = error.errors()[0]
        raise click.BadParameter(f"{'.'.join(map(str, fault['loc']))}: {fault['msg']}") from None
