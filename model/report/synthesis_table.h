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
    {64, 64, 1, 3630, 1210, 0, 8},    {64, 512, 1, 4851, 1330, 0, 11},    {512, 64, 1, 3972, 1222, 0, 8},
    {512, 512, 1, 5243, 1342, 0, 11}, {1024, 64, 1, 3286, 714, 8, 8},     {1024, 512, 1, 4619, 834, 8, 11},
    {2048, 64, 1, 3081, 718, 8, 8},   {2048, 512, 1, 4712, 838, 8, 11},   {4096, 64, 1, 3307, 722, 8, 8},
    {4096, 512, 1, 4466, 842, 8, 11}, {16384, 64, 1, 3114, 702, 32, 8},   {16384, 512, 1, 4617, 822, 32, 11},
    {512, 128, 1, 4270, 1342, 0, 11}, {512, 256, 1, 4558, 1342, 0, 11},   {4096, 128, 1, 3379, 842, 8, 11},
    {4096, 256, 1, 3972, 842, 8, 11}, {64, 64, 2, 5323, 1888, 0, 22},     {64, 512, 2, 7790, 2009, 0, 25},
    {512, 128, 2, 7054, 2021, 0, 25}, {1024, 64, 2, 4817, 944, 16, 22},   {1024, 512, 2, 7184, 1065, 16, 25},
    {4096, 64, 2, 4585, 952, 16, 22}, {4096, 256, 2, 6447, 1073, 16, 25}, {4096, 512, 2, 7203, 1073, 16, 25},
}};

/// The arbiter for so many displays, with a table of 256 slots and one more for each display.
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
    {64, 64, 1, 76.4},
    {64, 64, 2, 64.3},
    {64, 512, 1, 63.9},
    {64, 512, 2, 60.3},
    {4096, 64, 1, 70.8},
    {4096, 64, 2, 63.0},
    {4096, 512, 1, 64.7},
    {4096, 512, 2, 62.8},
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
    {{{{3020.86, 32.7042, 535.655, 707.278, -264.537}}, 0.055},
     {{{4789.91, -24.5783, 411.84, 601.045, 1210.25}}, 0.036}}};
inline constexpr std::array<Fit<5>, 2> kComposerRegisters{
    {{{{718.11, -0.704592, -4.30069, 498.831, 133.38}}, 0.015},
     {{{928.0, 4.0, -5.02787e-13, 960.0, 121.0}}, 0.001}}};
/// Of 1, displays, bits of the slot table.
constexpr Fit<3> kArbiterLookupTables{{{1776.51, 243.313, -0.152534}}, 0.061};
constexpr Fit<3> kArbiterRegisters{{{58.0258, -0.045559, 1.008}}, 0.001};
/// Nanoseconds a clock, of 1, log2(buffer_pixels / 64), log2(bus_bits / 64); of 1, displays.
inline constexpr std::array<Fit<3>, 2> kComposerPeriod{
    {{{{13.3962, 0.0701489, 0.648684}}, 0.024}, {{{15.7974, -0.0282721, 0.180367}}, 0.016}}};
constexpr Fit<2> kArbiterPeriod{{{11.8605, 0.531977}}, 0.019};

}  // namespace metabuffer::synthesis
