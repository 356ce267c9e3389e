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
    int lookup_tables;
    int registers;
    int block_rams;
    int multipliers;
};
inline constexpr std::array<ComposerRow, 16> kComposers{{
    {64, 64, 3247, 1210, 0, 8},
    {64, 512, 4862, 1330, 0, 11},
    {512, 64, 3703, 1222, 0, 8},
    {512, 512, 5310, 1342, 0, 11},
    {1024, 64, 3062, 714, 8, 8},
    {1024, 512, 4663, 834, 8, 11},
    {2048, 64, 3324, 718, 8, 8},
    {2048, 512, 4584, 838, 8, 11},
    {4096, 64, 3299, 722, 8, 8},
    {4096, 512, 4657, 842, 8, 11},
    {16384, 64, 3418, 702, 32, 8},
    {16384, 512, 4786, 822, 32, 11},
    {512, 128, 4377, 1342, 0, 11},
    {512, 256, 4771, 1342, 0, 11},
    {4096, 128, 3627, 842, 8, 11},
    {4096, 256, 4177, 842, 8, 11},
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
    double mhz;
};
inline constexpr std::array<ComposerClock, 4> kComposerClocks{{
    {64, 64, 71.1},
    {64, 512, 66.0},
    {4096, 64, 68.5},
    {4096, 512, 64.5},
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

/// Of 1, log2(buffer_pixels / 64), log2(bus_bits / 64), memory of lookup tables (0 or 1), more than a pixel a beat (0 or 1).
constexpr Fit<5> kComposerLookupTables{{{2659.65, 97.0871, 478.422, 785.418, 32.1859}}, 0.062};
constexpr Fit<5> kComposerRegisters{{{718.11, -0.704592, -4.30069, 498.831, 133.38}}, 0.015};
/// Of 1, displays, bits of the slot table.
constexpr Fit<3> kArbiterLookupTables{{{1776.51, 243.313, -0.152534}}, 0.061};
constexpr Fit<3> kArbiterRegisters{{{58.0258, -0.045559, 1.008}}, 0.001};
/// Nanoseconds a clock, of 1, log2(buffer_pixels / 64), log2(bus_bits / 64); of 1, displays.
constexpr Fit<3> kComposerPeriod{{{14.1101, 0.0738503, 0.332026}}, 0.004};
constexpr Fit<2> kArbiterPeriod{{{11.8605, 0.531977}}, 0.019};

}  // namespace metabuffer::synthesis
