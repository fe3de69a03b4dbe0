from .arguments import all_arguments, all_steps

__all__ = [
    "all_arguments",
    "all_steps",
]
