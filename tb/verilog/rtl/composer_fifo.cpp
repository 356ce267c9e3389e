// clang-format off
// Before SystemC's headers: with them Verilator's expect its older, global names.
#include "VerilatedComposerFifo.h"

#include "rtl/composer_fifo.h"
// clang-format on

#include <verilated.h>

#include <string>

#include "datapath/composer_buffer.h"
#include "rtl/verilated_pin.h"

namespace metabuffer::rtl {

namespace {

constexpr int kMaximumPixels = COMPOSER_MAX_BUFFER_PIXELS;
constexpr int kWindowRows = COMPOSER_WINDOW_ROWS;
constexpr int kWordBits = 32;  // of a wide pin's elements

/// Registers that reset does not set start with random values.
constexpr int kRandomRegisters = 2;

constexpr int kErrorFull = 1;
constexpr int kErrorEmpty = 2;

}  // namespace

ComposerFifo::ComposerFifo(const sc_core::sc_module_name& name, int capacity_pixels, int window_rows)
    : Block(name),
      second_row(window_rows > 1 ? std::make_unique<SecondRowPins>() : nullptr),
      context_(std::make_unique<VerilatedContext>()) {
    if (window_rows > kWindowRows) {
        SC_REPORT_ERROR("/metabuffer/composer_fifo/smoothing",
                        (std::string(this->name()) + ": a window of " + std::to_string(window_rows) +
                         " source rows is larger than the verilated FIFO's of " +
                         std::to_string(kWindowRows) + "; build with -DCOMPOSER_WINDOW_ROWS=2")
                            .c_str());
    }
    if (buffer_addresses(capacity_pixels) > kMaximumPixels) {
        SC_REPORT_ERROR(
            "/metabuffer/composer_fifo/size",
            (std::string(this->name()) + ": a buffer of " + std::to_string(capacity_pixels) +
             " pixels is larger than the verilated FIFO's memory of " + std::to_string(kMaximumPixels) +
             "; build with -DCOMPOSER_MAX_BUFFER_PIXELS=N, N a power of two")
                .c_str());
    }
    context_->randReset(kRandomRegisters);
    context_->randSeed(capacity_pixels);
    verilated_ = std::make_unique<VerilatedComposerFifo>(context_.get(), "composer_fifo");
    verilated_->clk_i = 0;
    verilated_->reset_i = 1;
    verilated_->row_read_i = 0;  // stays so with a window of one row
    put(verilated_->capacity_i, static_cast<std::uint32_t>(capacity_pixels));
    put(verilated_->last_address_i, static_cast<std::uint32_t>(buffer_addresses(capacity_pixels) - 1));
    verilated_->eval();
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
}

ComposerFifo::~ComposerFifo() { verilated_->final(); }

void ComposerFifo::clock_edge() {
    drive_inputs();
    verilated_->clk_i = 1;
    verilated_->eval();
    verilated_->clk_i = 0;
    verilated_->eval();
    word_o.write(verilated_->word_o);
    free_o.write(verilated_->free_o);
    if (second_row != nullptr) {
        second_row->next_word_o.write(verilated_->next_word_o);
        second_row->row_word_o.write(verilated_->row_word_o);
        second_row->row_next_word_o.write(verilated_->row_next_word_o);
    }
    if (!reset_i.read() && verilated_->error_o != 0) {
        report_error();
    }
}

void ComposerFifo::drive_inputs() {
    verilated_->reset_i = reset_i.read() ? 1 : 0;
    const FifoWrite& write = write_i.read();
    put(verilated_->write_count_i, write.count);
    put(verilated_->write_address_i, write.address);
    for (std::size_t word = 0; word < write.count; ++word) {
        verilated_->write_words_i[2 * word] = static_cast<EData>(write.words[word]);
        verilated_->write_words_i[2 * word + 1] = static_cast<EData>(write.words[word] >> kWordBits);
    }
    verilated_->read_i = read_i.read().enable ? 1 : 0;
    put(verilated_->read_address_i, read_i.read().address);
    if (second_row != nullptr) {
        verilated_->row_read_i = second_row->row_read_i.read().enable ? 1 : 0;
        put(verilated_->row_read_address_i, second_row->row_read_i.read().address);
    }
    put(verilated_->release_oldest_i, release_i.read().oldest);
    put(verilated_->release_newest_i, release_i.read().newest);
}

void ComposerFifo::report_error() const {
    const char* kind = "address";
    std::string what = "to use an address that it does not have";
    if (verilated_->error_o == kErrorFull) {
        kind = "full";
        what = "to hold more pixels than it can";
    } else if (verilated_->error_o == kErrorEmpty) {
        kind = "empty";
        what = "to release more pixels than it holds";
    }
    SC_REPORT_ERROR((std::string("/metabuffer/composer_fifo/") + kind).c_str(),
                    (std::string(name()) + " was told " + what).c_str());
}

void ComposerFifo::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, verilated_->level_o, path("level"));
    sc_trace(file, write_i.read(), path("write"));
    sc_trace(file, read_i.read(), path("read"));
    sc_trace(file, release_i.read(), path("release"));
    sc_core::sc_trace(file, word_o, path("word"));
    sc_core::sc_trace(file, free_o, path("free"));
    if (second_row != nullptr) {
        sc_core::sc_trace(file, second_row->next_word_o.port(), path("next_word"));
        sc_trace(file, second_row->row_read_i.read(), path("row_read"));
        sc_core::sc_trace(file, second_row->row_word_o.port(), path("row_word"));
        sc_core::sc_trace(file, second_row->row_next_word_o.port(), path("row_next_word"));
    }
}

}  // namespace metabuffer::rtl
