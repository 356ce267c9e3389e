#pragma once

#include <array>
#include <cstddef>

/// What synthesis makes of the composer and the arbiter in SystemVerilog (tb/verilog). scripts/make-synthesis-table writes
/// this file. Cells: Yosys 0.23, synth_xilinx, 7 series. Clocks: the same with the standard cells of
/// qflow-tech-osu018 (0.18 um), and OpenSTA 2.0.17, without wires and without the FIFO's memory.
namespace metabuffer::synthesis {

struct ComposerRow {
    int buffer_pixels;
    int bus_bits;
    int window_rows;  ///< source rows: 1 replicates, 2 smooth
    int lookup_tables;
    int registers;
    int block_rams;
    int multipliers;
};
inline constexpr std::array<ComposerRow, 24> kComposers{{
    {64, 64, 1, 3443, 1210, 0, 8},    {64, 512, 1, 4785, 1330, 0, 11},    {512, 64, 1, 4099, 1222, 0, 8},
    {512, 512, 1, 5151, 1342, 0, 11}, {1024, 64, 1, 3283, 714, 8, 8},     {1024, 512, 1, 4381, 834, 8, 11},
    {2048, 64, 1, 2977, 718, 8, 8},   {2048, 512, 1, 4343, 838, 8, 11},   {4096, 64, 1, 3222, 722, 8, 8},
    {4096, 512, 1, 4693, 842, 8, 11}, {16384, 64, 1, 3386, 702, 32, 8},   {16384, 512, 1, 4620, 822, 32, 11},
    {512, 128, 1, 4089, 1342, 0, 11}, {512, 256, 1, 4612, 1342, 0, 11},   {4096, 128, 1, 3713, 842, 8, 11},
    {4096, 256, 1, 4151, 842, 8, 11}, {64, 64, 2, 5476, 1888, 0, 22},     {64, 512, 2, 7748, 2009, 0, 25},
    {512, 128, 2, 7275, 2021, 0, 25}, {1024, 64, 2, 4865, 944, 16, 22},   {1024, 512, 2, 7242, 1065, 16, 25},
    {4096, 64, 2, 4974, 952, 16, 22}, {4096, 256, 2, 6492, 1073, 16, 25}, {4096, 512, 2, 7246, 1073, 16, 25},
}};

/// Of the arbiter for so many displays, with a table of 256 slots more than that.
struct ArbiterRow {
    int displays;
    int lookup_tables;
    int registers;
    int block_rams;
    int multipliers;
};
inline constexpr std::array<ArbiterRow, 4> kArbiters{{
    {2, 2156, 318, 0, 0},
    {4, 2841, 582, 0, 0},
    {8, 3465, 856, 0, 0},
    {16, 5538, 1154, 0, 0},
}};

struct ComposerClock {
    int buffer_pixels;
    int bus_bits;
    int window_rows;
    double mhz;
};
inline constexpr std::array<ComposerClock, 8> kComposerClocks{{
    {64, 64, 1, 66.5},
    {64, 64, 2, 63.1},
    {64, 512, 1, 69.8},
    {64, 512, 2, 63.0},
    {4096, 64, 1, 66.3},
    {4096, 64, 2, 63.6},
    {4096, 512, 1, 65.0},
    {4096, 512, 2, 62.3},
}};

struct ArbiterClock {
    int displays;
    double mhz;
};
inline constexpr std::array<ArbiterClock, 3> kArbiterClocks{{
    {2, 76.1},
    {4, 72.8},
    {16, 49.0},
}};

/// Coefficients of a sum, by least squares, and the largest error of a row as a share of it.
template <std::size_t Terms>
struct Fit {
    std::array<double, Terms> coefficients;
    double largest_error;
};

/// The smallest memory of a composer that is made of block RAMs.
constexpr int kFirstBlockRamPixels = 1024;

/// Of 1, log2(buffer_pixels / 64), log2(bus_bits / 64), memory of lookup tables (0 or 1), more than a pixel a beat (0 or
/// 1). The fits of a composer are for a window of one row and of two.
inline constexpr std::array<Fit<5>, 2> kComposerLookupTables{
    {{{{2719.17, 92.5138, 455.967, 844.797, -104.674}}, 0.069},
     {{{4565.47, 63.2289, 433.37, 986.31, 960.25}}, 0.044}}};
inline constexpr std::array<Fit<5>, 2> kComposerRegisters{
    {{{{718.11, -0.704592, -4.30069, 498.831, 133.38}}, 0.015},
     {{{928.0, 4.0, -5.02787e-13, 960.0, 121.0}}, 0.001}}};
/// Of 1, displays, bits of the slot table.
constexpr Fit<3> kArbiterLookupTables{{{1776.51, 243.313, -0.152534}}, 0.061};
constexpr Fit<3> kArbiterRegisters{{{58.0258, -0.045559, 1.008}}, 0.001};
/// Nanoseconds a clock, of 1, log2(buffer_pixels / 64), log2(bus_bits / 64); of 1, displays.
inline constexpr std::array<Fit<3>, 2> kComposerPeriod{
    {{{{14.7844, 0.0919442, -0.0682145}}, 0.018}, {{{15.7721, 0.00447987, 0.0588749}}, 0.005}}};
constexpr Fit<2> kArbiterPeriod{{{11.8605, 0.531977}}, 0.019};

}  // namespace metabuffer::synthesis
