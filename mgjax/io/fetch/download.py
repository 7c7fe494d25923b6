"""Files from a web server."""

from __future__ import annotations

import http.client
import urllib.error
import urllib.request

from mgjax.core.errors import FetchError

TIMEOUT_S = 30.0
"""Without a byte for so long a server counts as gone."""


def download(url: str, expected: str) -> bytes:
    """What is at an address, whole.

    Args:
        url: ``http`` or ``https``; proxies are those of the environment.
        expected: what should be there, for the error.

    Raises:
        FetchError: there is no connection, the server refuses, or it ends before the size that it
            stated.
    """
    try:
        request = urllib.request.Request(url, headers={"User-Agent": "mgjax"})
        with urllib.request.urlopen(request, timeout=TIMEOUT_S) as response:
            data = response.read()
    except urllib.error.HTTPError as error:
        with error:
            raise FetchError(
                got=f"{error.code} {error.reason}", expected=expected, place=url
            ) from None
    except http.client.IncompleteRead as error:
        size = len(error.partial)
        whole = "more" if error.expected is None else str(size + error.expected)
        raise FetchError(
            got=f"{size} bytes of {whole}", expected=f"all of {expected}", place=url
        ) from None
    except urllib.error.URLError as error:
        raise FetchError(
            got=f"no connection ({error.reason})", expected=expected, place=url
        ) from None
    except (OSError, http.client.HTTPException, ValueError) as error:
        why = str(error) or type(error).__name__
        raise FetchError(got=f"no answer ({why})", expected=expected, place=url) from None
    return data
