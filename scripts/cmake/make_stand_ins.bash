#!/usr/bin/env bash
# make_stand_ins.bash LIBRARY FOLDER COMPILER: of the libraries that LIBRARY, OpenImageIO's, needs for videos, volumes and
# computer vision, makes stand-ins in FOLDER, and prints their files. These libraries bring 200 others, take five times as
# long to load as all the rest, and start threads; no image that this project reads needs them. A stand-in has the name of a
# library and those of its symbols that LIBRARY asks for, with zeros behind them, which nobody calls.
set -euo pipefail
library=$1 folder=$2 compiler=$3
mkdir -p "$folder"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

ldd "$library" >"$scratch/loaded"
nm -D --undefined-only "$library" | awk '{ sub(/@.*/, "", $2); print $2 }' >"$scratch/asked"
while read -r name; do
  real=$(awk -v name="$name" '$1 == name { print $3 }' "$scratch/loaded")
  # Each symbol that is asked for, with its version, if it has one.
  nm -D --defined-only "$real" |
    awk 'NR == FNR { asked[$1]; next } { split($3, part, /@+/) } part[1] in asked { print part[1], part[2] }' \
      "$scratch/asked" - >"$scratch/symbols"
  awk 'BEGIN { print ".data" } { print ".globl " $1 "\n" $1 ": .zero 64" }' "$scratch/symbols" >"$scratch/symbols.S"
  awk 'NF == 2 { of[$2] = of[$2] $1 ";" } END { for (version in of) print version " { global: " of[version] " };" }' \
    "$scratch/symbols" >"$scratch/versions"
  options=(-shared -nostdlib "-Wl,-soname,$name")
  if [[ -s $scratch/versions ]]; then options+=("-Wl,--version-script=$scratch/versions"); fi
  "$compiler" "${options[@]}" -o "$folder/$name.part" "$scratch/symbols.S"
  # What is linked with it is linked again only if it differs.
  if cmp -s "$folder/$name.part" "$folder/$name"; then rm "$folder/$name.part"; else mv "$folder/$name.part" "$folder/$name"; fi
  echo "$folder/$name"
done < <(readelf -d "$library" | sed -n 's/.*(NEEDED).*\[\(lib\(opencv_\|av\|sw\|openvdb\).*\)\]/\1/p')
