// A composer of the Metabuffer. It receives its segment's pixels from its renderer's bus in its local memory and merges
// them with the pixels that come down its display's pipeline. Every output is registered. docs/replacing-a-block.md
// says what the pins mean and to which of them the machine is wired.
//
// It is made of the same parts as the model's. One clock edge is computed in three steps, each from the results of the
// one before: the pipeline side composites a pixel, the bus side receives a beat, the handshakes are driven. So a
// part's outputs named _next are what other parts need of this edge's outcome.
module composer #(
    parameter  int MAX_BUFFER_PIXELS = 4096,  // a power of two, 16 or more
    parameter  int WINDOW_ROWS       = 1,     // source rows in the window: 1, or 2 to smooth
    parameter  int POSITION_BITS     = 16,    // of a raster's width and height, no fewer than MULTIPLE_BITS
    parameter  int MULTIPLE_BITS     = 8,     // of a replication factor
    parameter  int INDEX_BITS        = 32,    // of a segment's pixel, no fewer than POSITION_BITS and 5
    parameter  int FRAME_BITS        = 32,    // of a frame's number
    parameter  int GAP_BITS          = 20,    // of the clocks from beat to beat
    localparam int ADDRESS_BITS      = $clog2(MAX_BUFFER_PIXELS),
    localparam int COUNT_BITS        = ADDRESS_BITS + 1
) (
    input logic clk_i,
    input logic reset_i,  // synchronous, active high

    // Configuration: constant while reset is low.
    input logic [15:0]              display_i,             // whose composer this is, from 1
    input logic [POSITION_BITS-1:0] raster_width_i,
    input logic [POSITION_BITS-1:0] raster_height_i,
    input logic [COUNT_BITS-1:0]    buffer_pixels_i,       // 1..MAX_BUFFER_PIXELS
    input logic [COUNT_BITS-1:0]    ready_space_pixels_i,
    input logic [3:0]               pixels_per_beat_i,     // 1..8
    input logic [GAP_BITS-1:0]      longest_gap_cycles_i,  // from beat to beat of a burst: a page miss and the beat
    input logic [7:0]               in_flight_pixels_i,    // that may come as BUSREADY falls, with that edge's beat
    input logic [4:0]               cut_cycles_i,          // from BUSREADY's fall to the last beat of its burst: 1..17
    input logic [1:0]               composition_i,         // 0 nearer wins, 1 the same with alpha key, 2 over
    input logic                     stall_mode_i,          // a starved pixel: 1 stalls the column, 0 is a glitch
    input logic                     smoothing_i,           // 1 bilinear, with two rows in the window; 0 replicates
    input logic [23:0]              far_z_i,               // Z of the far plane
    input logic [63:0]              background_i,
    input logic                     pipemaster_i,          // strap, read in reset

    // The bus of the renderer.
    input  logic [1:0]            bus_kind_i,       // 0 none, 1 frame start, 2 table row, 3 pixels
    input  logic                  bus_last_i,       // the table ends here
    input  logic [FRAME_BITS-1:0] bus_frame_i,      // the composited frame that the beat is of, from 0
    input  logic [3:0]            bus_count_i,      // pixels in this beat, 0..8
    input  logic [15:0]           bus_destination_i,
    input  logic [15:0]           bus_remaining_i,  // pixels of the burst after this beat
    input  logic [INDEX_BITS-1:0] bus_first_i,      // segment index of the beat's first pixel; of a row in its table
    input  logic [511:0]          bus_words_i,      // word 0 lowest
    output logic                  busready_o,
    output logic                  tableready_o,

    // The pipeline.
    input  logic        startframe_i,
    output logic        startframe_o,
    input  logic [63:0] pipe_pixel_i,
    input  logic        pipe_lost_i,
    output logic [63:0] pipe_pixel_o,
    output logic        pipe_valid_o,
    output logic        pipe_lost_o,
    input  logic        pipeready_i,  // from below
    output logic        pipeready_o,  // to above
    input  logic        column_stall_i,
    output logic        stall_o,

    // Status, for counters and debuggers. What happened at the edge just past:
    output logic                  composited_o,   // a raster pixel
    output logic                  starved_o,      // and its local pixel had not come
    output logic                  replayed_o,     // and its local pixel came from the window again
    output logic                  stalled_o,      // the column stood still for this composer
    output logic                  cut_o,          // BUSREADY was dropped in a burst
    output logic                  cutting_o,      // and beats of it may still come
    output logic [3:0]            late_o,         // pixels dropped that came after their last use
    output logic [INDEX_BITS-1:0] lost_o,         // pixels found to be lost
    output logic [FRAME_BITS-1:0] lost_tables_o,  // tables found to be lost, in part or whole
    output logic [2:0]            error_o,        // see ERROR_... of beat_receiver
    // What stands now:
    output logic                     running_o,
    output logic                     table_complete_o,
    output logic                     prefetched_o,
    output logic [FRAME_BITS-1:0]    frame_o,            // the frame composited, from 0; all ones before the first
    output logic [POSITION_BITS-1:0] x_o,                // the raster position that is next
    output logic [POSITION_BITS-1:0] y_o,
    output logic [INDEX_BITS-1:0]    pixel_o,            // the newest segment pixel that is needed there, if any is
    output logic [INDEX_BITS-1:0]    row_first_pixel_o,  // of the source row that this raster row shows
    output logic [POSITION_BITS-1:0] column_o,           // in it
    output logic [MULTIPLE_BITS-1:0] row_phase_o,        // the source row's repetition, from 0
    output logic [INDEX_BITS-1:0]    expected_o,         // segment index of the pixel that the bus must bring next
    output logic [COUNT_BITS-1:0]    held_o,
    output logic [15:0]              announced_o
);
  logic moving, start, pipemaster;
  assign moving = !stall_mode_i || !column_stall_i;

  // raster_walker
  logic frame_ends, covered, again, smooths, own_is_second;
  logic [6:0] weight_x, weight_y;
  logic releases, smoothed_releases;
  logic [INDEX_BITS-1:0] release_end;
  logic running_next, covered_next, across_next;
  logic [INDEX_BITS-1:0] newest_next;
  logic [ADDRESS_BITS-1:0] window_address, row_address;

  // beat_receiver
  logic head_segment, head_abandoned, left_apron, top_apron, head_abandoned_next, fetched_next;
  logic [POSITION_BITS-1:0] left, right, top, bottom, source_width, source_height;
  logic [INDEX_BITS-1:0] segment_pixels, released, head_arrived;
  logic [3:0] head_taken_count;
  logic [MULTIPLE_BITS-1:0] last_phase, left_phase, top_phase;
  logic [22:0] reciprocal;
  logic [ADDRESS_BITS-1:0] base, write_address;
  logic [3:0] write_count;
  logic [COUNT_BITS-1:0] release_oldest, release_newest;

  // composer_fifo
  logic [63:0] word, next_word, row_word, row_next_word;
  logic [1:0] fifo_error;
  logic [COUNT_BITS-1:0] fifo_free;

  // merge_stage
  logic missing;

  beat_receiver #(
      .MAX_BUFFER_PIXELS(MAX_BUFFER_PIXELS),
      .WINDOW_ROWS(WINDOW_ROWS),
      .POSITION_BITS(POSITION_BITS),
      .MULTIPLE_BITS(MULTIPLE_BITS),
      .INDEX_BITS(INDEX_BITS),
      .FRAME_BITS(FRAME_BITS),
      .GAP_BITS(GAP_BITS)
  ) receiver (
      .clk_i,
      .reset_i,
      .display_i,
      .raster_width_i,
      .raster_height_i,
      .buffer_pixels_i,
      .ready_space_pixels_i,
      .pixels_per_beat_i,
      .longest_gap_cycles_i,
      .in_flight_pixels_i,
      .cut_cycles_i,
      .bus_kind_i,
      .bus_last_i,
      .bus_frame_i,
      .bus_count_i,
      .bus_destination_i,
      .bus_remaining_i,
      .bus_first_i,
      .bus_words_i(bus_words_i[127:0]),
      .busready_o,
      .tableready_o,
      .frame_ends_i(frame_ends),
      .releases_i(releases),
      .missing_i(missing),
      .smoothed_releases_i(smoothed_releases),
      .release_end_i(release_end),
      .head_segment_o(head_segment),
      .head_abandoned_o(head_abandoned),
      .left_o(left),
      .right_o(right),
      .top_o(top),
      .bottom_o(bottom),
      .source_width_o(source_width),
      .source_height_o(source_height),
      .segment_pixels_o(segment_pixels),
      .last_phase_o(last_phase),
      .left_phase_o(left_phase),
      .top_phase_o(top_phase),
      .left_apron_o(left_apron),
      .top_apron_o(top_apron),
      .reciprocal_o(reciprocal),
      .base_o(base),
      .released_o(released),
      .head_abandoned_next_o(head_abandoned_next),
      .head_arrived_o(head_arrived),
      .head_taken_count_o(head_taken_count),
      .fetched_next_o(fetched_next),
      .held_i(held_o),
      .write_count_o(write_count),
      .write_address_o(write_address),
      .release_oldest_o(release_oldest),
      .release_newest_o(release_newest),
      .cut_o,
      .cutting_o,
      .late_o,
      .lost_o,
      .lost_tables_o,
      .error_o,
      .table_complete_o,
      .expected_o,
      .announced_o
  );

  raster_walker #(
      .WINDOW_ROWS(WINDOW_ROWS),
      .ADDRESS_BITS(ADDRESS_BITS),
      .POSITION_BITS(POSITION_BITS),
      .MULTIPLE_BITS(MULTIPLE_BITS),
      .INDEX_BITS(INDEX_BITS),
      .FRAME_BITS(FRAME_BITS)
  ) walker (
      .clk_i,
      .reset_i,
      .raster_width_i,
      .raster_height_i,
      .smoothing_i,
      .start_i(start),
      .moving_i(moving),
      .head_segment_i(head_segment),
      .left_i(left),
      .right_i(right),
      .top_i(top),
      .bottom_i(bottom),
      .source_width_i(source_width),
      .source_height_i(source_height),
      .segment_pixels_i(segment_pixels),
      .last_phase_i(last_phase),
      .left_phase_i(left_phase),
      .top_phase_i(top_phase),
      .left_apron_i(left_apron),
      .top_apron_i(top_apron),
      .reciprocal_i(reciprocal),
      .base_i(base),
      .released_i(released),
      .running_o,
      .frame_ends_o(frame_ends),
      .covered_o(covered),
      .again_o(again),
      .smooths_o(smooths),
      .own_is_second_o(own_is_second),
      .weight_x_o(weight_x),
      .weight_y_o(weight_y),
      .releases_o(releases),
      .smoothed_releases_o(smoothed_releases),
      .release_end_o(release_end),
      .running_next_o(running_next),
      .covered_next_o(covered_next),
      .newest_next_o(newest_next),
      .across_next_o(across_next),
      .window_address_o(window_address),
      .row_address_o(row_address),
      .frame_o,
      .x_o,
      .y_o,
      .pixel_o,
      .row_first_pixel_o,
      .column_o,
      .row_phase_o
  );

  // The local memory is a ring of MAX_BUFFER_PIXELS, of which buffer_pixels_i are used at a time. The read is for the
  // raster position of the next edge.
  logic reading;
  assign reading = running_next && covered_next;

  composer_fifo #(
      .MAX_PIXELS(MAX_BUFFER_PIXELS),
      .WINDOW_ROWS(WINDOW_ROWS)
  ) fifo (
      .clk_i,
      .reset_i,
      .capacity_i(buffer_pixels_i),
      .last_address_i({ADDRESS_BITS{1'b1}}),
      .write_count_i(write_count),
      .write_address_i(write_address),
      .write_words_i(bus_words_i),
      .read_i(reading),
      .read_address_i(window_address),
      .release_oldest_i(release_oldest),
      .release_newest_i(release_newest),
      .word_o(word),
      .next_word_o(next_word),
      .row_read_i(reading && across_next),
      .row_read_address_i(row_address),
      .row_word_o(row_word),
      .row_next_word_o(row_next_word),
      .level_o(held_o),
      .free_o(fifo_free),
      .error_o(fifo_error)
  );

  merge_stage #(
      .WINDOW_ROWS(WINDOW_ROWS),
      .INDEX_BITS(INDEX_BITS)
  ) merge (
      .clk_i,
      .reset_i,
      .composition_i,
      .stall_mode_i,
      .far_z_i,
      .background_i,
      .pipemaster_i(pipemaster),
      .moving_i(moving),
      .pipe_pixel_i,
      .pipe_lost_i,
      .pipe_pixel_o,
      .pipe_valid_o,
      .pipe_lost_o,
      .stall_o,
      .running_i(running_o),
      .covered_i(covered),
      .again_i(again),
      .smooths_i(smooths),
      .own_is_second_i(own_is_second),
      .weight_x_i(weight_x),
      .weight_y_i(weight_y),
      .running_next_i(running_next),
      .covered_next_i(covered_next),
      .newest_next_i(newest_next),
      .abandoned_i(head_abandoned),
      .abandoned_next_i(head_abandoned_next),
      .arrived_i(head_arrived),
      .taken_count_i(head_taken_count),
      .word_i(word),
      .next_word_i(next_word),
      .row_word_i(row_word),
      .row_next_word_i(row_next_word),
      .missing_o(missing),
      .composited_o,
      .starved_o,
      .replayed_o,
      .stalled_o
  );

  pipeline_handshake handshake (
      .clk_i,
      .reset_i,
      .pipemaster_i,
      .pipemaster_o(pipemaster),
      .moving_i(moving),
      .startframe_i,
      .startframe_o,
      .pipeready_i,
      .pipeready_o,
      .running_i(running_o),
      .running_next_i(running_next),
      .fetched_next_i(fetched_next),
      .start_o(start),
      .prefetched_o
  );

  // These stay unused: the FIFO is never asked for more than it can do, and late pixels are released as they come.
  logic unused;
  assign unused = ^{fifo_free, fifo_error};
endmodule
