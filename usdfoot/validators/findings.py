"""What a validator finds, in USD's terms."""

from __future__ import annotations

from pxr import Usd, UsdValidation

from usdfoot.errors import UsdfootError

__all__ = ["finding"]


def finding(
    name: str, prim: Usd.Prim, what: str, *, remedy: str = "", attribute: str = "", warning: bool = False
) -> UsdValidation.ValidationError:
    """A validation error that names the prim, what is wrong and what would be right.

    Args:
        name: Of the error, by which fixers are found.
        prim: Where it is.
        what: What is wrong, in a few words.
        remedy: What would be right.
        attribute: Name of the attribute it is about; "" = the prim.
        warning: A warning instead of an error.
    """
    path = prim.GetPath().AppendProperty(attribute) if attribute else prim.GetPath()
    kind = UsdValidation.ValidationErrorType.Warn if warning else UsdValidation.ValidationErrorType.Error
    site = UsdValidation.ValidationErrorSite(prim.GetStage(), path)
    return UsdValidation.ValidationError(name, kind, [site], str(UsdfootError(path, what, remedy)))
