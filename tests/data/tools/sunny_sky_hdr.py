#!/usr/bin/env python3
"""Writes a Radiance picture of a sunny sky (equirectangular, run-length coded): sunny_sky_hdr.py OUT.hdr [WIDTH]"""
import math
import sys


def rgbe(colour):
    largest = max(colour)
    if largest < 1e-32:
        return (0, 0, 0, 0)
    mantissa, exponent = math.frexp(largest)
    scale = mantissa * 256.0 / largest
    return tuple(min(int(c * scale), 255) for c in colour) + (exponent + 128,)


def sky(direction, sun):
    x, y, z = direction
    if y < 0.0:
        return (0.16, 0.13, 0.10)
    haze = math.exp(-4.0 * y)
    colour = [a + haze * (b - a) for a, b in zip((0.10, 0.22, 0.55), (0.75, 0.78, 0.80))]
    cosine = sum(a * b for a, b in zip(direction, sun))
    glow = 6.0e4 if cosine > math.cos(math.radians(0.8)) else 1.2 * max(cosine, 0.0) ** 200
    return tuple(c + glow * t for c, t in zip(colour, (1.0, 0.93, 0.80)))


def runs(channel):
    """A row of one channel as the format codes it: 128 + n and a byte, or n and n bytes."""
    out, i = bytearray(), 0
    while i < len(channel):
        same = 1
        while i + same < len(channel) and same < 127 and channel[i + same] == channel[i]:
            same += 1
        if same > 3:
            out += bytes((128 + same, channel[i]))
            i += same
            continue
        begin = i
        while i < len(channel) and i - begin < 128 and len(set(channel[i : i + 4])) > 1:
            i += 1
        i = max(i, begin + 1)
        out += bytes((i - begin,)) + bytes(channel[begin:i])
    return bytes(out)


def main():
    width = int(sys.argv[2]) if len(sys.argv) > 2 else 1024
    height = width // 2
    elevation, azimuth = math.radians(38), math.radians(-50)
    sun = (math.cos(elevation) * math.sin(azimuth), math.sin(elevation), math.cos(elevation) * math.cos(azimuth))
    with open(sys.argv[1], "wb") as out:
        out.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width))
        for row in range(height):
            polar = math.pi * (row + 0.5) / height
            pixels = []
            for column in range(width):
                around = 2.0 * math.pi * (column + 0.5) / width - math.pi
                flat = math.sin(polar)
                pixels.append(rgbe(sky((flat * math.sin(around), math.cos(polar), flat * math.cos(around)), sun)))
            out.write(bytes((2, 2, width >> 8, width & 255)))
            for channel in range(4):
                out.write(runs([p[channel] for p in pixels]))


main()
