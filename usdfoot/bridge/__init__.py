"""The edge between USD and arrays: names, units, axes, schemas."""

from usdfoot.bridge.schema import register_schemas

# Here, because USD takes no schemas once its registry was used: before any reader or writer can have used it.
register_schemas()
