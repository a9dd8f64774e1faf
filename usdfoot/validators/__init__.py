"""USD's validators for what usdfoot reads and writes; importing this, or USD's loading the plugin, registers them.

Never raises: a module that does keeps USD from loading anybody's validators.
"""

import logging

try:
    from usdfoot.validators.registration import register_validators

    register_validators()
except Exception as error:  # whatever is missing or too old here, the validators of others must load
    logging.getLogger(__name__).warning("the validators of usdfoot are not registered: %s", error)
