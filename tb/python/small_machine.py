"""A machine that takes next to no time to run, as a dict, and where the project is."""

import os
import pathlib

SOURCE = pathlib.Path(os.environ["METABUFFER_SOURCE"])
PROGRAM = os.environ["METABUFFER_PROGRAM"]
WIDTH, HEIGHT = 12, 4


def scenario(image="view.ppm", **keys):
    """One renderer whose image fills the one display."""
    return {"name": "small", "displays": {"width": WIDTH, "height": HEIGHT}, "composer": {"ready_space_pixels": 2},
            "bus": {"burst_pixels": 2},
            "renderers": [{"frames": [{"image": image, "z": 0, "viewport": {"x": 0, "y": 0}}]}], **keys}


def pixels():
    """The image; all its bytes differ."""
    return bytes(range(3 * WIDTH * HEIGHT))


def write_image(folder, name="view.ppm"):
    (folder / name).write_bytes(b"P6\n%d %d\n255\n" % (WIDTH, HEIGHT) + pixels())
