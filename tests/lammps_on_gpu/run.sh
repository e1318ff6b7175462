#!/bin/bash
# SPDX-License-Identifier: MIT OR Apache-2.0
# LAMMPS with ellgran on a GPU of NVIDIA, whose driver and an MPI are all that the machine must have: trajectories beside those of the host, on
# one rank and, where there is an mpirun, on two; rates, and rates of LAMMPS' own spheres. A table comes last, logs go to $OUT. Ends within
# $LIMIT seconds, 480; with 1 where trajectories differ. PARTS names what is done, of: rates trajectories packings floors.
#
# `cargo xtask gpu --pack DIR --lammps` puts all that it needs into DIR/lammps.
cd "$(dirname "$0")" || exit 1
OUT=${OUT:-$PWD/out}
mkdir -p "$OUT/host" "$OUT/gpu" "$OUT/ranks"
RANKS=""
G="-nocite -k on g 1 -sf kk"
began=$SECONDS
LIMIT=${LIMIT:-480}   # s
PARTS=${PARTS:-rates trajectories packings floors}
does() { [[ " $PARTS " = *" $1 "* ]]; }
left() { echo $((LIMIT - (SECONDS - began))); }
lmp() {   # lmp LOG words...: what it printed to LOG
  local log=$1; shift
  local most=$(left); [ "$most" -gt ${MOST:-40} ] && most=${MOST:-40}
  [ "$most" -lt 3 ] && { echo "no time left" > "$OUT/$log"; return 1; }
  timeout "$most" $RANKS ./lmp "$@" -log none > "$OUT/$log" 2>&1 < /dev/null
  local status=$?
  [ $status -ne 0 ] && { echo "$log: status $status"; tail -n 4 "$OUT/$log"; }
  return $status
}
chmod +x lmp
nvidia-smi --query-gpu=name,driver_version,clocks.max.sm --format=csv,noheader 2>/dev/null | tee "$OUT/gpu.txt"

compare() {   # largest difference of each kind over its largest value, of frames $1/frame.N
  awk -v ref="$1" -v other="$2" 'BEGIN {
    split("x x x v v v angmom angmom angmom f f f torque torque torque quat quat quat quat", kind, " ")
    while ((getline line < ref) > 0) {
      if ((getline line2 < other) <= 0) { print "FAILED: shorter"; exit 1 }
      n = split(line, a, " "); m = split(line2, b, " ")
      if (n != 20 || a[1] !~ /^[0-9]+$/) continue
      if (a[1] != b[1]) { print "FAILED: other grains"; exit 1 }
      for (k = 2; k <= n; k++) {
        d = a[k] - b[k]; if (d < 0) d = -d
        s = a[k]; if (s < 0) s = -s
        if (!(d <= 1e300)) { print "FAILED: no number"; exit 1 }
        if (d > most[kind[k-1]]) most[kind[k-1]] = d
        if (s > scale[kind[k-1]]) scale[kind[k-1]] = s
      }
      rows++
    }
    if (!rows) { print "FAILED: nothing compared"; exit 1 }
    # In a crowd that is not chaotic within the run, roundings grow to this at most; forces of two instruction sets of the host do.
    bound = 1e-9
    printf "%d grains:", rows
    split("x v angmom quat f torque", order, " ")
    for (k = 1; k <= 6; k++) {
      apart = most[order[k]] / (scale[order[k]] + 1e-300)
      printf " %s %.1e", order[k], apart
      if (!(apart <= bound)) too_far = 1
    }
    printf too_far ? " FAILED\n" : "\n"
  }'
}
table=""
cases() {   # each with its name first
  echo "friction compare.lmp"
  echo "half compare.lmp -var motion 'nve/ellipsoid velocities half' -var steps 200"
  echo "frictionless compare.lmp -var law 'nfd 1e7 0.3 50 50' -var steps 200"
  echo "walls walls.lmp -var steps 200"
  echo "curved curved_walls.lmp"
}
compare_lists() {   # largest difference of two lists of numbers over the largest of them
  awk -v ref="$1" -v other="$2" 'BEGIN {
    if ((getline line < ref) <= 0 || (getline line2 < other) <= 0) { print "FAILED: nothing compared"; exit 1 }
    n = split(line, a, " "); if (split(line2, b, " ") != n || !n) { print "FAILED: other lists"; exit 1 }
    for (k = 1; k <= n; k++) {
      d = a[k] - b[k]; if (d < 0) d = -d
      s = a[k]; if (s < 0) s = -s
      if (!(d <= 1e300)) { print "FAILED: no number"; exit 1 }
      if (d > most) most = d
      if (s > scale) scale = s
    }
    printf "%.1e%s\n", most / scale, (scale > 0 && most <= 1e-9 * scale) ? "" : " FAILED"
  }'
}
on() {   # on host|gpu|ranks NAME DECK words...: with a directory for its frames
  local where=$1 name=$2 deck=$3 how="-nocite" RANKS=""
  shift 3
  [ "$where" = gpu ] && how=$G
  # Two on one GPU; messages by way of the host, which every MPI can do.
  [ "$where" = ranks ] && { how="$G -pk kokkos gpu/aware off"; RANKS="mpirun -n 2"; }
  mkdir -p "$OUT/$where/$name"
  lmp "compare-$where-$name.log" $how -in "$deck" -var out "$OUT/$where/$name" "$@"
}
does trajectories && while read -r line; do eval "MOST=200 on host $line" < /dev/null & done < <(cases)

floor() {   # floor CELLS HEIGHT: an STL file of so many cells of two triangles along each side, to 6 copies of the box and 5 mm more, with waves
  awk -v n="$1" -v height="$2" -v low=-0.005 -v high=0.1828 '
    function corner(x, y) { printf "vertex %.7g %.7g %.7g\n", x, y, height * (sin(700 * x) * cos(600 * y) - 1) }
    BEGIN {
    print "solid floor"
    for (i = 0; i < n; i++) for (j = 0; j < n; j++) {
      x = low + (high - low) * i / n; X = low + (high - low) * (i + 1) / n
      y = low + (high - low) * j / n; Y = low + (high - low) * (j + 1) / n
      for (k = 0; k < 2; k++) {
        print "facet normal 0 0 1\nouter loop"
        corner(x, y)
        if (k) { corner(X, Y); corner(x, Y) }
        else { corner(X, y); corner(X, Y) }
        print "endloop\nendfacet"
      }
    }
    print "endsolid floor"
  }' > "$OUT/floor.$1.$2.stl"
}
floor 10 0
floor 100 0
floor 100 3e-4

# The driver assembles a module of kernels when it is used for the first time, and keeps it.
first() { MOST=200 lmp "first-${1// /-}.log" $G -in "${@:2}" -var copies "1 1 1" -var steps 10 -var warm 1; echo "first start, $1: $((SECONDS - began)) s"; }
first grains time.lmp &
first triangles time_walls.lmp -var floor "mesh $OUT/floor.10.0.stl" &
mkdir -p "$OUT/scratch"
first "all walls" curved_walls.lmp -var out "$OUT/scratch" &
wait
rm -rf "$OUT/scratch"

# Rates, and where the time goes when the host waits for each kernel
rate() {   # rate NAME LOG
  table+=$(awk -v name="$1" '/^Loop time/ { s = $4; n = $9; a = $12 }
    /^(Pair|Neigh|Comm|Modify|Output|Other) / { split($0, c, "|"); split(c[3], t, " "); part[$1] = t[1] }
    END { if (!n) { print name ": no result"; exit }
      printf "%-26s %8d grains %9.3g grain-steps/s  %8.3f ms/step", name, a, a * n / s, 1e3 * s / n
      for (p in part) if (part[p] > 0) printf "  %s %.3f", p, 1e3 * part[p] / n
      printf "\n" }' "$OUT/$2")$'\n'
}
ellipsoids() { lmp "ellipsoids-${1// /-}.log" $G -in time.lmp "${@:2}"; rate "ellipsoids $1" "ellipsoids-${1// /-}.log"; }
spheres() {
  local log=spheres-$1.log
  # fix neigh/history/kk asks for newton off.
  lmp "$log" $G -pk kokkos neigh half newton off -in spheres.lmp "${@:2}"
  rate "spheres $1" "$log"
}
if does rates; then
  ellipsoids 110592 -var copies "3 3 3" -var steps 500
  spheres 110592 -var copies "3 3 3" -var steps 500
  ellipsoids 1032192 -var copies "6 6 7"
  spheres 1032192 -var copies "6 6 7"
fi

# The same trajectories
if does trajectories; then
  before=$SECONDS
  while read -r line; do eval "on gpu $line"; done < <(cases)
  on gpu again curved_walls.lmp -var again 1 -var from "$OUT/host/curved/first.restart"
  wheres=gpu
  if command -v mpirun > /dev/null; then
    wheres="gpu ranks"
    while read -r line; do eval "on ranks $line"; done < <(cases)
    on ranks again curved_walls.lmp -var again 1 -var from "$OUT/host/curved/first.restart"
  else
    table+="two ranks: no mpirun"$'\n'
  fi
  echo "trajectories: $((SECONDS - before)) s"
  mkdir -p "$OUT/host/again"
  cp "$OUT"/host/curved/frame.[1-9]* "$OUT"/host/curved/forces.* "$OUT/host/again"
  rm -f "$OUT"/host/again/frame.300
  for where in $wheres; do
    for name in curved again; do
      for step in 2 3; do
        table+="$where, $name, forces of walls: $(compare_lists "$OUT/host/$name/forces.$step" "$OUT/$where/$name/forces.$step")"$'\n'
      done
    done
    for name in friction half frictionless walls curved again; do
      for frame in "$OUT/host/$name"/frame.*; do
        table+="$where, $name ${frame##*/}: $(compare "$frame" "$OUT/$where/$name/${frame##*/}")"$'\n'
      done
    done
  done
fi
rm -rf "$OUT/host" "$OUT/gpu" "$OUT/ranks"

# Other numbers of grains, other packings
if does packings; then
  ellipsoids 4096 -var copies "1 1 1" -var steps 2000
  ellipsoids 32768 -var copies "2 2 2" -var steps 1000
  packing() { ellipsoids "$1 $2" -var data "$1.data" "${@:3}"; }
  packing needles 128000 -var copies "5 5 5"
  packing mixture 435375 -var copies "5 5 5"
  packing gas 512000 -var copies "5 5 5" -var steps 500
  MOST=100 ellipsoids 4096000 -var copies "10 10 10" -var steps 100 -var warm 20
  MOST=100 spheres 4096000 -var copies "10 10 10" -var steps 100 -var warm 20
  MOST=150 ellipsoids 9691136 -var copies "13 13 14" -var steps 50 -var warm 10
fi

# Floors: none, a plane, triangles of two sizes, and uneven ones
on_floor() { lmp "floor-${1// /-}.log" $G -in time_walls.lmp "${@:2}"; rate "floor $1" "floor-${1// /-}.log"; }
if does floors; then
  on_floor none -var floors 0
  on_floor plane -var floor "zplane 0 NULL"
  on_floor "200 triangles" -var floor "mesh $OUT/floor.10.0.stl"
  on_floor "20000 triangles" -var floor "mesh $OUT/floor.100.0.stl"
  on_floor "20000 uneven" -var floor "mesh $OUT/floor.100.3e-4.stl"

  export CUDA_LAUNCH_BLOCKING=1
  on_floor "none waiting" -var floors 0
  on_floor "plane waiting" -var floor "zplane 0 NULL"
  on_floor "20000 triangles waiting" -var floor "mesh $OUT/floor.100.0.stl"
  on_floor "20000 uneven waiting" -var floor "mesh $OUT/floor.100.3e-4.stl"
  ellipsoids waiting -var copies "6 6 7" -var steps 50 -var warm 20
  spheres waiting -var copies "6 6 7" -var steps 50 -var warm 20
fi
rm -f "$OUT"/floor.*.stl
echo "----- $((SECONDS - began)) s"
printf '%s' "$table" | tee "$OUT/table.txt"
case $table in *FAILED*) exit 1 ;; esac
