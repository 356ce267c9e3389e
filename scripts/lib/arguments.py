"""Types of arguments, for argparse."""

from typing import Callable, Optional


def whole_number(lowest: int, largest: Optional[int] = None) -> Callable[[str], int]:
    def parse(text: str) -> int:
        number = int(text)
        if number < lowest or (largest is not None and number > largest):
            raise ValueError
        return number
    # argparse shows this name in its message.
    parse.__name__ = f"whole number from {lowest} {'on' if largest is None else f'to {largest}'}"
    return parse
