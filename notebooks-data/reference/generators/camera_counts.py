#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""camera_counts.csv: temperatures of raw counts of radiometric thermal cameras.

Constants are those that the cameras stored with published images (Wikimedia Commons; file, camera and author in the
comments); counts are the lowest, one in the middle and the highest of each, with their place in the image. In 40 digits,
from decimals as written.
  apparent  T with count + O = R1 / (R2 (exp(B / T) - F)), by bisection: not by the inverse that is tested
  surface   the T at which emissivity x signal(T) + (1 - emissivity) x signal(reflected) is that of the count
"""

import argparse

from mpmath import mp, mpf

from tables import digits, write_table

mp.dps = 40

# file, (R1, B, F, O, R2), emissivity, reflected temperature in C, (count, x, y) ...
IMAGES = [
    # FLIR i7, Zaereth
    ("ducks.png", ("16327.72265625", "1424.80004882812", "1.35000002384186", "-6872", "0.0231583472341299"),
     "0.949999988079071", "19.9999938964844", [(11350, 35, 58), (12022, 17, 60), (12679, 61, 46)]),
    # FLIR b60, Russ Miller-Johnson
    ("tower.png", ("13559.1220703125", "1368.09997558594", "1", "-5202", "0.0103647718206048"),
     "1", "19.9999938964844", [(6953, 6, 2), (12847, 17, 90), (13994, 51, 65)]),
    # FLIR E60, Herbertweidner
    ("floor_heating.png", ("14985.9296875", "1398.09997558594", "1", "-6233", "0.0112832169979811"),
     "0.949999988079071", "19.9900146484375", [(17034, 53, 10), (17782, 17, 120), (20324, 167, 0)]),
    ("moving_car.png", ("14985.9296875", "1398.09997558594", "1", "-6233", "0.0112832169979811"),
     "0.949999988079071", "19.9900146484375", [(13046, 17, 1), (14624, 17, 120), (16736, 213, 140)]),
    ("moving_mercedes.png", ("14985.9296875", "1398.09997558594", "1", "-6233", "0.0112832169979811"),
     "0.949999988079071", "19.9900146484375", [(12258, 200, 97), (14613, 17, 120), (17483, 137, 114)]),
    # ThermaCAM SC640, Eclipse sx
    ("water_pipe.png", ("21170.00390625", "1501.90002441406", "1", "-7482", "0.0127567416056991"),
     "0.899999976158142", "19.9999938964844", [(17004, 29, 0), (17097, 17, 240), (20034, 561, 289)]),
    # FLIR T440, Tadmark5364
    ("windmill.png", ("15618.2041015625", "1410.5", "1", "-5456", "0.010833689942956"),
     "0.920000016689301", "-6.00998535156248", [(8917, 36, 2), (10487, 17, 120), (14041, 216, 235)]),
    # FLIR T420, Razryvnye
    ("solar_halo.png", ("15827.7451171875", "1414.5", "1", "-5567", "0.0109624397009611"),
     "0.949999988079071", "19.9999938964844", [(9791, 83, 205), (10216, 17, 120), (12820, 153, 0)]),
]
ZERO_C = mpf("273.15")


def signal(constants, temperature_k):
    r1, b, f, _, r2 = constants
    return r1 / (r2 * (mp.exp(b / temperature_k) - f))


def temperature_of(constants, wanted):
    low, high = mpf(50), mpf(5000)
    while high - low > mpf(10) ** -35:
        middle = (low + high) / 2
        low, high = (middle, high) if signal(constants, middle) < wanted else (low, middle)
    return low


def rows():
    for file, texts, emissivity, reflected_c, counts in IMAGES:
        constants = [mpf(text) for text in texts]
        e, reflected_k = mpf(emissivity), mpf(reflected_c) + ZERO_C
        for count, x, y in counts:
            total = count + constants[3]
            surface = (total - (1 - e) * signal(constants, reflected_k)) / e
            yield [file, str(x), str(y), str(count), *texts, emissivity, digits(reflected_k, 25),
                   digits(temperature_of(constants, total), 25), digits(temperature_of(constants, surface), 25)]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--folder", help="write there instead, to compare")
    header = "file,x,y,count,r1,b_k,f,o,r2,emissivity,reflected_k,apparent_k,surface_k".split(",")
    write_table("camera_counts.csv", header, rows(), parser.parse_args().folder)


if __name__ == "__main__":
    main()
