"""A machine that takes next to no time to run, for tests of what is around it."""

SCENARIO = """name: small
displays: {width: 12, height: 4}
composer: {ready_space_pixels: 2}
bus: {burst_pixels: 2}
renderers:
  - frames: [{image: view.ppm, z: 0, viewport: {x: 0, y: 0}}]
"""
IMAGE = b"P6\n12 4\n255\n" + bytes(144)


def fill(folder, scenario=SCENARIO):
    """Puts the scenario and its image there."""
    (folder / "scenario.yaml").write_text(scenario)
    (folder / "view.ppm").write_bytes(IMAGE)
