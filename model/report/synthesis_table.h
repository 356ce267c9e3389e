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
    {64, 64, 1, 3502, 1305, 0, 11},    {64, 512, 1, 4710, 1305, 0, 11},    {512, 64, 1, 4004, 1317, 0, 11},
    {512, 512, 1, 5107, 1317, 0, 11},  {1024, 64, 1, 3262, 809, 8, 11},    {1024, 512, 1, 4339, 809, 8, 11},
    {2048, 64, 1, 3304, 813, 8, 11},   {2048, 512, 1, 4328, 813, 8, 11},   {4096, 64, 1, 3359, 817, 8, 11},
    {4096, 512, 1, 4394, 817, 8, 11},  {16384, 64, 1, 3387, 797, 32, 11},  {16384, 512, 1, 4499, 797, 32, 11},
    {512, 128, 1, 3993, 1317, 0, 11},  {512, 256, 1, 4547, 1317, 0, 11},   {4096, 128, 1, 3317, 817, 8, 11},
    {4096, 256, 1, 3777, 817, 8, 11},  {64, 64, 2, 6569, 2053, 0, 26},     {64, 512, 2, 8250, 2053, 0, 26},
    {512, 128, 2, 7462, 2065, 0, 26},  {1024, 64, 2, 6113, 1109, 16, 26},  {1024, 512, 2, 7344, 1109, 16, 26},
    {4096, 64, 2, 6115, 1117, 16, 26}, {4096, 256, 2, 6850, 1117, 16, 26}, {4096, 512, 2, 7538, 1117, 16, 26},
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
    {2, 3630, 318, 0, 0},
    {4, 5046, 582, 0, 0},
    {8, 5603, 856, 0, 0},
    {16, 7224, 1154, 0, 0},
}};

struct ComposerClock {
    int buffer_pixels;
    int bus_bits;
    int window_rows;
    double mhz;
};
inline constexpr std::array<ComposerClock, 8> kComposerClocks{{
    {64, 64, 1, 110.7},
    {64, 64, 2, 75.2},
    {64, 512, 1, 105.5},
    {64, 512, 2, 75.0},
    {4096, 64, 1, 108.9},
    {4096, 64, 2, 74.3},
    {4096, 512, 1, 104.7},
    {4096, 512, 2, 74.4},
}};

struct ArbiterClock {
    int displays;
    double mhz;
};
inline constexpr std::array<ArbiterClock, 3> kArbiterClocks{{
    {2, 120.9},
    {4, 119.0},
    {16, 114.8},
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
    {{{{2837.55, 80.2477, 534.785, 853.126, -514.276}}, 0.054},
     {{{5677.0, 70.0, 496.0, 1066.0, -71.0}}, 0.027}}};
inline constexpr std::array<Fit<5>, 2> kComposerRegisters{
    {{{{813.11, -0.704592, -4.30069, 498.831, 13.3799}}, 0.014},
     {{{1093.0, 4.0, 1.52407e-12, 960.0, -4.60432e-12}}, 0.001}}};
/// Of 1, displays, bits of the slot table.
constexpr Fit<3> kArbiterLookupTables{{{2767.31, 33.6501, 3.54563}}, 0.06};
constexpr Fit<3> kArbiterRegisters{{{58.0258, -0.045559, 1.008}}, 0.001};
/// Nanoseconds a clock, of 1, log2(buffer_pixels / 64), log2(bus_bits / 64); of 1, displays.
inline constexpr std::array<Fit<3>, 2> kComposerPeriod{
    {{{{9.05265, 0.0184782, 0.135602}}, 0.003}, {{{13.3113, 0.0223837, 0.00289517}}, 0.002}}};
constexpr Fit<2> kArbiterPeriod{{{8.24637, 0.0293792}}, 0.005};

}  // namespace metabuffer::synthesis
