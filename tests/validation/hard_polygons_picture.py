"""The picture of docs/guide/hpmc.md: the last checkpoint of a run of polygons as SVG.

protomer hpmc run --shape polygon:5 --bodies 256 --packing-fraction 0.65 --equilibration 1000 --sweeps 1000 -o DIR
python tests/validation/hard_polygons_picture.py DIR docs/images/hpmc-pentagons.svg
"""

import colorsys
import json
import math
import sys
from pathlib import Path

CORNERS, SIZE = 5, 480


def main():
    data = (Path(sys.argv[1]) / "checkpoint.bin").read_bytes()
    begin = data.index(b'{"log"')
    state = json.JSONDecoder().raw_decode(data[begin:].decode("utf-8", "ignore"))[0]["state"]
    edge, flat = state["edge"], state["positions"]
    scale = SIZE / edge
    radius = math.sqrt(2 / (CORNERS * math.sin(math.tau / CORNERS)))
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIZE} {SIZE}" width="{SIZE}" height="{SIZE}">']
    lines.append(f'<rect width="{SIZE}" height="{SIZE}" fill="#fff" stroke="#444"/>')
    for number, (w, _, _, z) in enumerate(state["orientations_wxyz"]):
        angle = 2 * math.atan2(z, w)
        hue = (angle * CORNERS / math.tau) % 1
        colour = "#%02x%02x%02x" % tuple(round(255 * part) for part in colorsys.hls_to_rgb(hue, 0.68, 0.55))
        for dx in (-edge, 0, edge):
            for dy in (-edge, 0, edge):
                x, y = flat[2 * number] + dx, flat[2 * number + 1] + dy
                if not (-radius < x < edge + radius and -radius < y < edge + radius):
                    continue
                turns = [angle + math.tau * k / CORNERS for k in range(CORNERS)]
                points = [(x + radius * math.cos(turn), edge - y - radius * math.sin(turn)) for turn in turns]
                text = " ".join(f"{scale * a:.1f},{scale * b:.1f}" for a, b in points)
                lines.append(f'<polygon points="{text}" fill="{colour}" stroke="#333" stroke-width="0.7"/>')
    lines.append("</svg>")
    Path(sys.argv[2]).write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
