#include "rtl/merge_stage.h"

#include "datapath/composer_buffer.h"

namespace metabuffer::rtl {

MergeStage::MergeStage(const sc_core::sc_module_name& name, const Scenario& scenario)
    : Block(name),
      second_row(scenario.composer.window_rows() > 1 ? std::make_unique<SecondRowPins>() : nullptr),
      composition_(scenario.composition),
      may_stall_(scenario.composer.may_stall()),
      far_z_(far_z(scenario.depth_format)),
      background_{scenario.background_pixel(), true, false},
      pixel_bits_(segment_pixel_bits(scenario)),
      position_(registers_, "position", pixel_bits_),
      window_(registers_, second_row != nullptr ? 2 : 1, buffer_addresses(scenario.composer.buffer_pixels),
              pixel_bits_, pins()) {
    clocked_.evaluates(&MergeStage::drive, {ahead_i, progress_i, running_i});
}

void MergeStage::reset() {
    registers_.reset();
    pipemaster_ = pipemaster_i.read();
    pipe_o.write(PipePixel{});
}

PixelWindow::Pins MergeStage::pins() const {
    PixelWindow::Pins pins{write_i};
    pins.words[0][0] = &word_i;
    if (second_row != nullptr) {
        pins.words[0][1] = &second_row->next_word_i;
        pins.words[1] = {&second_row->row_word_i, &second_row->row_next_word_i};
    }
    return pins;
}

void MergeStage::clock_edge() {
    const bool moves = !may_stall_ || !column_stall_i.read();
    const RasterStep& ahead = ahead_i.read();
    bool frame_ends = false;
    if (moves && running_i.read()) {
        composite();
        frame_ends = position_->last;
    } else if (moves && pipe_o.read().valid) {
        starved_ = false;
        pipe_o.write(PipePixel{});
    }
    if (ahead.covered || position_->covered) {
        window_.clock_edge({moves ? ahead : position_.value(), ahead}, progress_i.read());
    }
    if (frame_ends) {
        window_.forget();
    }
    if (moves) {
        position_ = ahead;
    }
}

bool MergeStage::missing() const {
    const SegmentProgress& progress = progress_i.read();
    return position_->covered && !progress.abandoned && !progress.has_arrived(position_->newest());
}

void MergeStage::composite() {
    const SegmentProgress& progress = progress_i.read();
    const PipePixel& upstream = pipemaster_ ? background_ : pipe_i.read();
    PipePixel out{upstream.pixel, true, upstream.lost || progress.abandoned};
    starved_ = missing();
    if (position_->covered && !starved_ && !progress.abandoned) {
        const Pixel local = second_row == nullptr
                                ? window_.pixel(position_, progress)
                                : blend(window_.pixels(position_, progress), position_->weight_x,
                                        position_->weight_y, composition_, far_z_);
        out.pixel = compose(composition_, local, upstream.pixel);
    }
    pipe_o.write(out);
}

void MergeStage::drive() {
    const RasterStep& ahead = ahead_i.read();
    const SegmentProgress& progress = progress_i.read();
    window_.choose_reads(ahead, progress);
    read_o.write(window_.read(0));
    if (second_row != nullptr) {
        second_row->row_read_o.write(window_.read(1));
    }
    const bool starves = running_i.read() && missing();
    missing_o.write(starves);
    if (may_stall_) {
        stall_o.write(starves);
    }
}

void MergeStage::trace(sc_core::sc_trace_file* file) const { registers_.trace(file, path("")); }

}  // namespace metabuffer::rtl
