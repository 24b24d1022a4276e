# SPDX-License-Identifier: Apache-2.0
# NIIRS over aperture and pitch from a sweep of aperture_against_pitch.toml; designs that miss a constraint are pale,
# and those whose wells the bright target fills have none.
#   gnuplot -e 'sweep = "satellite"; chart = "niirs_map.png"' niirs_map.gp
set datafile separator comma
set table $designs
niirs(text) = strlen(text) > 0 ? real(text) : NaN
plot sweep . "/designs.csv" using "optics.aperture":"frame.pitch":(niirs(strcol("niirs_giqe5"))):"feasible" with table
unset table
set datafile separator whitespace

set dgrid3d 33, 37, 16
set contour base
set cntrparam levels discrete 4.8, 5, 5.1, 5.15, 5.2
unset surface
set table $contours
splot $designs using 1:2:3
unset table
unset dgrid3d

set terminal pngcairo size 760, 440 font "sans-serif,11" background "#ffffff"
set output chart
set title "NIIRS (GIQE 5) at 0.5 m samples from 500 km"
set xlabel "aperture, mm"
set ylabel "pitch, um"
set xrange [287.5:1212.5]
set yrange [3.875:12.125]
set cbrange [4.6:5.25]
set palette defined (0 "#440154", 1 "#3b528b", 2 "#21918c", 3 "#5ec962", 4 "#fde725")
set key off
set tics out nomirror
set style textbox opaque noborder
set label "telescope longer than 8 m" at 860, 10.2 center front
set label "a bright scene\nfills the wells" at 1090, 4.9 center front
set label "NIIRS\nbelow 5" at 368, 6.3 center front
pale(feasible) = feasible > 0 ? 0 : 150
plot $designs using 1:2:3 with image, \
     $designs using 1:2:(255):(255):(255):(pale($4)) with rgbalpha, \
     $contours using 1:2 with lines lc "#404040", \
     $contours using 1:2:3 every 60::25 with labels font ",9" boxed
