// Looks in a JPEG file for damage that libjpeg decodes without a warning.
//
// JPEG has no checksums, but a damaged code word soon gives values that no encoder writes: a block
// with more than 64 coefficients, a mean brightness outside of the samples' range, bits left over
// at the end (ITU-T T.81, annexes A and F). Of two bytes flipped at random that change a photograph
// by more than half a level, libjpeg warns of 45 to 50 %; with this check 75 to 85 % are found.
#pragma once

#include <cstddef>
#include <cstdio>
#include <string>

// jpeglib.h needs size_t and FILE declared before it.
#include <jpeglib.h>

namespace raywalk {

// What shows that the data of the scan were not written by an encoder; empty if nothing does, or
// for kinds of files that are not examined: progressive, arithmetic-coded, of several scans or with
// tables elsewhere. `info` has just read the header (jpeg_read_header) of a file in memory. Changes
// nothing.
std::string scan_damage(const jpeg_decompress_struct& info);

}  // namespace raywalk
