from .campaign import Campaign
from .engine import Result, plan, search
from .profiles import PROFILES, Profile
from .shards import Case, Found, Shard, Tally, explore

__all__ = [
    "PROFILES",
    "Campaign",
    "Case",
    "Found",
    "Profile",
    "Result",
    "Shard",
    "Tally",
    "explore",
    "plan",
    "search",
]
