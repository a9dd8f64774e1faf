"""Registers usdfoot's API schemas with USD and looks for them on prims whether or not they are registered."""

import logging
from functools import cache
from pathlib import Path

from pxr import Plug, Sdf, Tf, Usd, UsdGeom

from usdfoot.bridge.tokens import PLUGIN

_logger = logging.getLogger(__name__)

_PRINTS = (
    UsdGeom.Tokens.protoIndices,
    UsdGeom.Tokens.positions,
    UsdGeom.Tokens.orientations,
    UsdGeom.Tokens.orientationsf,
    UsdGeom.Tokens.invisibleIds,
)
"""Attributes of a PointInstancer that say something of footsteps."""


def schema_folder() -> Path | None:
    """Folder of plugInfo.json and generatedSchema.usda, also what goes on `PXR_PLUGINPATH_NAME`.

    It lies inside the installed package, or beside the package in a source tree. None where neither is there.
    """
    package = Path(__file__).resolve().parents[1]
    candidates = (package / "schemas", package.parent / "schemas")
    return next((folder for folder in candidates if (folder / "plugInfo.json").is_file()), None)


def register_schemas() -> None:
    """Make USD know the schemas, so that fallback values, documentation and validation work.

    USD looks at plugins only until its schema registry is first used. After that registering has no effect, and
    nothing else suffers: everything usdfoot reads and writes is the same without it. Never raises; calling it again
    does nothing.
    """
    folder = schema_folder()
    registry = Plug.Registry()
    if folder is None or registry.GetPluginWithName(PLUGIN) is not None:
        return
    try:
        registry.RegisterPlugins(str(folder))
    except Tf.ErrorException as error:
        _logger.warning("schemas in %s are not registered: %s", folder, error)


def applied_apis(prim: Usd.Prim) -> tuple[str, ...]:
    """Names of all API schemas authored on a prim, strongest first, composed over its layers and arcs.

    `Usd.Prim.GetAppliedSchemas` hides the names that are not registered. The metadata `apiSchemas` has them, but not
    those that another layer adds to, and takes several times as long to ask.
    """
    return tuple(prim.GetPrimTypeInfo().GetAppliedAPISchemas())


def has_api(prim: Usd.Prim, name: str) -> bool:
    """Whether an API schema is applied to a prim, registered or not.

    Args:
        prim: Prim to look at.
        name: Name as in `tokens.Schema`; for multiple-apply schemas with the instance, as ``UsdfootContactAPI:left``.
    """
    return name in applied_apis(prim)


def declared_type(name: str) -> Sdf.ValueTypeName | None:
    """Type that the schemas, registered or not, or USD's own of prints give an attribute; None if they have none."""
    return _declared_types().get(name)


@cache
def declared_kind(name: str) -> type | None:
    """Python's type of such values."""
    declared = declared_type(name)
    return None if declared is None else type(declared.defaultValue)


@cache
def _declared_types() -> dict[str, Sdf.ValueTypeName]:
    """Types of all attributes of schemas applied once, and of the prints of a PointInstancer, by name."""
    folder = schema_folder()
    layer = Sdf.Layer.FindOrOpen(str(folder / "generatedSchema.usda")) if folder else None
    schemas = layer.rootPrims if layer else ()
    prints = Usd.SchemaRegistry().FindConcretePrimDefinition("PointInstancer")
    return {
        **{str(name): prints.GetAttributeDefinition(name).GetTypeName() for name in _PRINTS},
        **{attribute.name: attribute.typeName for schema in schemas for attribute in schema.attributes},
    }
