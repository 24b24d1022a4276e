# SPDX-License-Identifier: Apache-2.0
"""Messages about files that mtfkit wrote for itself: they name the argument that the caller gave."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING

from mtfkit.errors import Error, ToleranceError

if TYPE_CHECKING:
    from contextlib import AbstractContextManager


def in_arguments(text: str, folder: str, names: Mapping[str, str]) -> str:
    """The text with the arguments in place of files of that folder. A place in a file that nobody sees goes away."""
    for name, argument in names.items():
        text = re.sub(rf"{re.escape(f'{folder}/{name}')}(:\d+(:\d+)?)?", argument.replace("\\", r"\\"), text)
    return text.replace(f"{folder}/", "")


@contextmanager
def reworded(words: Callable[[str], str]) -> Iterator[None]:
    """Errors from within with other words."""
    try:
        yield
    except Error as error:
        said = words(str(error))
        if said == str(error):
            raise
        if isinstance(error, ToleranceError):
            raise ToleranceError(said, error.reachable) from None
        raise type(error)(said) from None


def about_arguments(folder: str, names: Mapping[str, str]) -> AbstractContextManager[None]:
    """Errors from within tell of arguments and not of files of the folder."""
    return reworded(lambda text: in_arguments(text, folder, names))
