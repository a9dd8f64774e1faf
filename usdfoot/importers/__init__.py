"""Files that are not USD, as what usdfoot plans and animates."""
