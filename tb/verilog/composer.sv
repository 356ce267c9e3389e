// A composer of the Metabuffer. It receives its segment's pixels from its renderer's bus in its local memory and merges
// them with the pixels that come down its display's pipeline. Every output is registered. docs/replacing-a-block.md
// says what the pins mean and to which of them the machine is wired.
//
// One clock edge is computed in three steps, each from the results of the one before: the pipeline side composites a
// pixel, the bus side receives a beat, the handshakes are driven.
module composer #(
    parameter  int MAX_BUFFER_PIXELS = 4096,  // a power of two, 16 or more
    parameter  int WINDOW_ROWS       = 1,     // source rows in the window: 1, or 2 to smooth
    localparam int ADDRESS_BITS      = $clog2(MAX_BUFFER_PIXELS),
    localparam int COUNT_BITS        = ADDRESS_BITS + 1
) (
    input logic clk_i,
    input logic reset_i,  // synchronous, active high

    // Configuration: constant while reset is low.
    input logic [15:0]           display_i,             // whose composer this is, from 1
    input logic [15:0]           raster_width_i,
    input logic [15:0]           raster_height_i,
    input logic [COUNT_BITS-1:0] buffer_pixels_i,       // 1..MAX_BUFFER_PIXELS
    input logic [COUNT_BITS-1:0] ready_space_pixels_i,
    input logic [3:0]            pixels_per_beat_i,     // 1..8
    input logic [19:0]           longest_gap_cycles_i,  // from a beat of a burst to the next: a page miss and the beat
    input logic [7:0]            in_flight_pixels_i,    // that may come once BUSREADY falls, with the beat it falls at
    input logic [4:0]            cut_cycles_i,          // from BUSREADY's fall to the last beat of its burst: 1..17
    input logic [1:0]            composition_i,         // 0 nearer wins, 1 the same with alpha key, 2 over
    input logic                  stall_mode_i,          // a starved pixel: 1 stalls the column, 0 is a glitch
    input logic                  smoothing_i,           // 1 bilinear, with two rows in the window; 0 replicates
    input logic [23:0]           far_z_i,               // Z of the far plane
    input logic [63:0]           background_i,
    input logic                  pipemaster_i,          // strap, read in reset

    // The bus of the renderer.
    input  logic [1:0]       bus_kind_i,         // see BUS_...
    input  logic             bus_last_i,         // the table ends here
    input  logic [31:0]      bus_frame_i,        // the composited frame that the beat is of, from 0
    input  logic [3:0]       bus_count_i,        // pixels in this beat, 0..8
    input  logic [15:0]      bus_destination_i,
    input  logic [15:0]      bus_remaining_i,    // pixels of the burst after this beat
    input  logic [31:0]      bus_first_i,        // segment index of the beat's first pixel; of a row in its table
    input  logic [511:0]     bus_words_i,        // word 0 lowest
    output logic             busready_o,
    output logic             tableready_o,

    // The pipeline.
    input  logic        startframe_i,
    output logic        startframe_o,
    input  logic [63:0] pipe_pixel_i,
    input  logic        pipe_lost_i,
    output logic [63:0] pipe_pixel_o,
    output logic        pipe_valid_o,
    output logic        pipe_lost_o,
    input  logic        pipeready_i,     // from below
    output logic        pipeready_o,     // to above
    input  logic        column_stall_i,
    output logic        stall_o,

    // Status, for counters and debuggers. What happened at the edge just past:
    output logic        composited_o,  // a raster pixel
    output logic        starved_o,     // and its local pixel had not come
    output logic        replayed_o,    // and its local pixel came from the window again
    output logic        stalled_o,     // the column stood still for this composer
    output logic        cut_o,         // BUSREADY was dropped in a burst
    output logic        cutting_o,     // and beats of it may still come
    output logic [3:0]  late_o,        // pixels dropped that came after their last use
    output logic [31:0] lost_o,        // pixels found to be lost
    output logic [31:0] lost_tables_o, // tables found to be lost, in part or whole
    output logic [2:0]  error_o,       // see ERROR_...
    // What stands now:
    output logic                  running_o,
    output logic                  table_complete_o,
    output logic                  prefetched_o,
    output logic [31:0]           frame_o,            // the frame composited, from 0; all ones before the first
    output logic [15:0]           x_o,                // the raster position that is next
    output logic [15:0]           y_o,
    output logic [31:0]           pixel_o,            // the newest segment pixel that is needed there, if any is
    output logic [31:0]           row_first_pixel_o,  // of the source row that this raster row shows
    output logic [15:0]           column_o,           // in it
    output logic [7:0]            row_phase_o,        // the source row's repetition, from 0
    output logic [31:0]           expected_o,         // index in the segment of the pixel that the bus must bring next
    output logic [COUNT_BITS-1:0] held_o,
    output logic [15:0]           announced_o
);
  localparam logic [1:0] BUS_NONE = 2'd0;
  localparam logic [1:0] BUS_FRAME_START = 2'd1;
  localparam logic [1:0] BUS_TABLE_ROW = 2'd2;
  localparam logic [1:0] BUS_PIXELS = 2'd3;

  localparam logic [2:0] ERROR_NONE = 3'd0;
  localparam logic [2:0] ERROR_FULL = 3'd1;      // a pixel for a full buffer
  localparam logic [2:0] ERROR_ORDER = 3'd2;     // a pixel that has come before
  localparam logic [2:0] ERROR_NO_TABLE = 3'd3;  // a pixel of no frame
  localparam logic [2:0] ERROR_TABLES = 3'd4;    // a third frame's table
  localparam logic [2:0] ERROR_FRAME = 3'd5;     // a beat of a frame that is over, or that cannot have begun
  localparam logic [2:0] ERROR_ROW = 3'd6;       // a row that has come before

  localparam logic [1:0] COMPOSE_Z = 2'd0;
  localparam logic [1:0] COMPOSE_Z_ALPHA_KEY = 2'd1;

  localparam bit SMOOTHS = WINDOW_ROWS > 1;
  localparam int MOST_FRAMES_AHEAD = 65535;  // beyond the newest frame that is known: no bus gets there
  localparam int SPACE_BITS = (COUNT_BITS > 16 ? COUNT_BITS : 16) + 1;  // counts and announced pixels together

  // ---- registers ----

  logic pipemaster;

  // Two frames: the one that is composited or is next to be (`head`), and the one after it on the bus. Segment bounds
  // are clipped to the raster, end values one past the last.
  logic [31:0] number[2];
  logic        table_complete[2];      // or lost
  logic        has_segment[2];
  logic        abandoned[2];           // pixels or rows were lost: nothing of it is kept or waited for
  logic [15:0] left[2];
  logic [15:0] right[2];
  logic [15:0] top[2];
  logic [15:0] bottom[2];
  logic [15:0] source_width[2];
  logic [7:0]  last_phase[2];          // replication factor - 1
  logic [7:0]  left_phase[2];          // repetitions of the raster's first source column left of the raster
  logic [7:0]  top_phase[2];           // repetitions of the raster's first source row above the raster
  logic        left_apron[2];          // the raster's first source column is the segment's second one
  logic        top_apron[2];           // the same for its first row
  logic [15:0] source_height[2];
  logic [31:0] segment_pixels[2];
  logic [31:0] arrived[2];
  logic [ADDRESS_BITS-1:0] base[2];    // address of the segment's pixel 0
  logic        head;
  logic [1:0]  frames;
  logic [31:0] heard;                  // number of the frame that is to begin next
  logic [31:0] composited;             // number of the frame that is composited or is next to be
  logic        table_lost;             // of the newest frame: its pixels are dropped
  logic [15:0] next_row;               // index of the table row that must come next
  logic        receiving_ended;        // pixels of a frame that is over, the one that is not `head`, still come
  logic [31:0] released;               // pixels of the head frame that have had their last use
  logic [COUNT_BITS-1:0]   held;       // the FIFO's level
  logic [ADDRESS_BITS-1:0] write_address;
  logic [19:0]             silent_cycles;  // since the burst's last beat, while more of it is announced

  // The walk over the raster; x_o, y_o and other outputs are part of it.
  logic        running;
  logic        row_covered;
  logic        covered;
  logic        missing;                // covered, and a segment pixel that is needed has not come
  logic [15:0] source_row;             // that this raster row shows
  logic [7:0]  column_phase;
  logic [7:0]  first_row_phase;        // of the source row shown: not 0 only for one cut by the raster's top

  // ---- step 1: the pipeline side ----

  // A frame whose table did not come is composited in its turn, abandoned and without a segment.
  logic head_missed, head_segment, head_abandoned;
  assign head_missed = composited != (frames != 2'd0 ? number[head] : heard);
  assign head_segment = frames != 2'd0 && has_segment[head] && !head_missed;
  assign head_abandoned = head_missed || (frames != 2'd0 && abandoned[head]);

  logic moving, compositing, starting, raster_row_ends, frame_ends, last_use, releasing, replaying;
  assign moving = !stall_mode_i || !column_stall_i;
  assign compositing = moving && running;
  assign starting = moving && !running && (pipemaster ? pipeready_o : startframe_i);
  assign raster_row_ends = x_o == raster_width_i - 16'd1;
  assign frame_ends = compositing && raster_row_ends && y_o == raster_height_i - 16'd1;
  assign last_use = (row_phase_o == last_phase[head] || y_o == bottom[head] - 16'd1) &&
                    (column_phase == last_phase[head] || x_o == right[head] - 16'd1);
  assign releasing = compositing && covered && last_use;  // of a segment that is replicated
  assign replaying = compositing && covered && !missing && !head_abandoned && row_phase_o > first_row_phase;

  logic [15:0] x_next, y_next, column_next;
  logic [7:0] column_phase_next, row_phase_next, first_row_phase_next;
  logic [31:0] row_first_pixel_next, pixel_next;
  logic row_covered_next, covered_next, running_next;
  logic [15:0] source_row_next;

  always_comb begin : walk
    x_next = x_o;
    y_next = y_o;
    column_next = column_o;
    column_phase_next = column_phase;
    row_phase_next = row_phase_o;
    first_row_phase_next = first_row_phase;
    row_first_pixel_next = row_first_pixel_o;
    row_covered_next = row_covered;
    source_row_next = source_row;
    if (starting) begin
      x_next = '0;
      y_next = '0;
      column_next = {15'd0, left_apron[head]};
      column_phase_next = left_phase[head];
      row_phase_next = top_phase[head];
      first_row_phase_next = top_phase[head];
      row_first_pixel_next = top_apron[head] ? {16'd0, source_width[head]} : '0;
      source_row_next = {15'd0, top_apron[head]};
      row_covered_next = head_segment && top[head] == '0 && bottom[head] != '0;
    end else if (compositing) begin
      if (raster_row_ends) begin
        x_next = '0;
        y_next = y_o + 16'd1;
        column_next = {15'd0, left_apron[head]};
        column_phase_next = left_phase[head];
        if (row_covered) begin
          if (row_phase_o == last_phase[head]) begin
            row_phase_next = '0;
            first_row_phase_next = '0;
            row_first_pixel_next = row_first_pixel_o + {16'd0, source_width[head]};
            source_row_next = source_row + 16'd1;
          end else begin
            row_phase_next = row_phase_o + 8'd1;
          end
        end
        row_covered_next = head_segment && y_next >= top[head] && y_next < bottom[head];
      end else begin
        x_next = x_o + 16'd1;
        if (covered) begin
          if (column_phase == last_phase[head]) begin
            column_phase_next = '0;
            column_next = column_o + 16'd1;
          end else begin
            column_phase_next = column_phase + 8'd1;
          end
        end
      end
    end
    running_next = starting || (running && !frame_ends);
    covered_next = row_covered_next && x_next >= left[head] && x_next < right[head];
    pixel_next = row_first_pixel_next + {16'd0, column_next};
  end

  // ---- step 1: smoothing ----

  // A replication factor of 1 leaves nothing to smooth.
  logic smooths;
  logic [7:0] head_multiple;
  logic [6:0] reach;  // raster pixels beyond its own block in which a source pixel is mixed
  assign smooths = SMOOTHS && smoothing_i && last_phase[head] != '0;
  assign head_multiple = last_phase[head] + 8'd1;
  assign reach = head_multiple[7:1];

  // The next position's window: the own source pixel, one beside it in its row, one across it in another row, and the one
  // that is both. They lie on the side of the block's centre on which the raster pixel lies.
  logic [8:0] column_position, row_position;  // 2 phase + 1
  logic beside_is_left_next, across_is_above_next, beside_next, across_next;
  logic [31:0] newest_next;                              // of them all
  logic [ADDRESS_BITS-1:0] window_address, row_address;  // of the first one in either row

  always_comb begin : window
    column_position = {column_phase_next, 1'b1};
    row_position = {row_phase_next, 1'b1};
    beside_is_left_next = column_position < {1'b0, head_multiple};
    across_is_above_next = row_position < {1'b0, head_multiple};
    beside_next = smooths && column_position != {1'b0, head_multiple} &&
                  (beside_is_left_next ? column_next != '0 : column_next != source_width[head] - 16'd1);
    across_next = smooths && row_position != {1'b0, head_multiple} &&
                  (across_is_above_next ? source_row_next != '0 : source_row_next != source_height[head] - 16'd1);
    window_address = base[head] + ADDRESS_BITS'(pixel_next) - ADDRESS_BITS'(beside_next && beside_is_left_next);
    row_address = across_is_above_next ? window_address - ADDRESS_BITS'(source_width[head])
                                       : window_address + ADDRESS_BITS'(source_width[head]);
    newest_next = pixel_next + {31'd0, beside_next && !beside_is_left_next};
    if (across_next && !across_is_above_next) newest_next = newest_next + {16'd0, source_width[head]};
  end

  // A source row is released in the last raster row that is mixed of it. At the bottom of the raster two may be in use
  // still: then the upper one is released pixel by pixel, and all others at the end.
  logic last_raster_row, last_raster_column, releases_row_above, row_releases, smoothed_releases;
  logic [31:0] released_row, release_end;  // one past the last pixel that is released

  always_comb begin : smoothed_release
    last_raster_row = y_o == bottom[head] - 16'd1;
    last_raster_column = x_o == right[head] - 16'd1;
    releases_row_above = source_row != '0 && (row_phase_o == {1'b0, reach} - 8'd1 ||
                                              (last_raster_row && row_phase_o < {1'b0, reach}));
    row_releases = releases_row_above || last_raster_row;
    released_row = releases_row_above ? row_first_pixel_o - {16'd0, source_width[head]} : row_first_pixel_o;
    if (starting) release_end = {16'd0, source_width[head]};  // a row above the raster that nothing needs
    else if (!last_raster_column) release_end = released_row + {16'd0, column_o};
    else if (last_raster_row) release_end = segment_pixels[head];
    else release_end = released_row + {16'd0, source_width[head]};
    smoothed_releases = smooths && release_end > released;
    if (starting) begin
      smoothed_releases = smoothed_releases && head_segment && top_apron[head] && top_phase[head] >= {1'b0, reach};
    end else begin
      smoothed_releases = smoothed_releases && compositing && covered && row_releases &&
                          (last_raster_column || (column_o != '0 && column_phase >= {1'b0, reach} - 8'd1));
    end
  end

  // The state that the frame's end leaves to the bus side.
  logic        head_1;
  logic [1:0]  frames_1;
  logic [31:0] composited_1;
  logic        receiving_ended_1;
  logic [31:0] released_1;
  logic [COUNT_BITS-1:0] held_1;

  always_comb begin : release_pixels
    head_1 = head;
    frames_1 = frames;
    composited_1 = composited;
    receiving_ended_1 = receiving_ended;
    released_1 = released;
    held_1 = held;
    if (smoothed_releases) begin
      released_1 = release_end;
      if (!head_abandoned && arrived[head] > released) begin
        held_1 = held - COUNT_BITS'((arrived[head] < release_end ? arrived[head] : release_end) - released);
      end
    end else if (releasing && !smooths) begin
      released_1 = pixel_o + 32'd1;
      if (!missing && !head_abandoned) held_1 = held - COUNT_BITS'(1);
    end
    if (frame_ends && head_missed) begin
      composited_1 = composited + 32'd1;
    end else if (frame_ends && frames != 2'd0) begin
      if (has_segment[head]) receiving_ended_1 = frames == 2'd1 && arrived[head] != segment_pixels[head];
      head_1 = !head;
      frames_1 = frames - 2'd1;
      composited_1 = composited + 32'd1;
      released_1 = '0;
    end
  end

  // Merging. The FIFO has read the local pixel at the edge before, even if the pixel came at that edge.
  logic [63:0] fifo_word, fifo_next_word, fifo_row_word, fifo_row_next_word;
  logic [63:0] local_pixel, merged_pixel, upstream_pixel;
  logic        upstream_lost;

  assign upstream_pixel = pipemaster ? background_i : pipe_pixel_i;
  assign upstream_lost = pipe_lost_i && !pipemaster;

  // t / 255 rounded to nearest, exact for t <= 255 * 255.
  function automatic logic [8:0] div255(input logic [15:0] t);
    logic [16:0] rounded;
    rounded = {1'b0, t} + 17'd128;
    rounded = rounded + {8'd0, rounded[16:8]};
    div255 = rounded[16:8];
  endfunction

  function automatic logic [7:0] over_channel(input logic [7:0] front, input logic [7:0] back,
                                              input logic [7:0] front_alpha);
    logic [9:0] sum;
    sum = {2'd0, front} + {1'd0, div255({8'd0, back} * {8'd0, ~front_alpha})};
    over_channel = sum > 10'd255 ? 8'd255 : sum[7:0];
  endfunction

  function automatic logic [63:0] over(input logic [31:0] back, input logic [55:0] front);
    over = {8'd0, front[55:32], over_channel(front[31:24], back[31:24], front[31:24]),
            over_channel(front[23:16], back[23:16], front[31:24]), over_channel(front[15:8], back[15:8], front[31:24]),
            over_channel(front[7:0], back[7:0], front[31:24])};
  endfunction

  always_comb begin : merge
    logic nearer;
    nearer = local_pixel[55:32] < upstream_pixel[55:32];
    unique case (composition_i)
      COMPOSE_Z: merged_pixel = nearer ? local_pixel : upstream_pixel;
      COMPOSE_Z_ALPHA_KEY: merged_pixel = nearer && local_pixel[31:24] != '0 ? local_pixel : upstream_pixel;
      default: begin
        if (nearer) merged_pixel = over(upstream_pixel[31:0], local_pixel[55:0]);
        else merged_pixel = over(local_pixel[31:0], upstream_pixel[55:0]);
      end
    endcase
  end

  // Of the bus side, step 2: a row for this composer, and whose frame it is of.
  logic own_row, source_1;
  logic [7:0] row_multiple;

  if (SMOOTHS) begin : gen_smoothing
    logic [22:0] reciprocal[2], row_reciprocal;  // of the replication factor
    logic beside, beside_is_left, across;        // the window of the position composited now
    logic new_row, own_is_second;
    logic [6:0] weight_x, weight_y;
    logic [63:0] blended;
    assign new_row = starting || (compositing && raster_row_ends);
    assign own_is_second = beside && beside_is_left;

    blend_counter column_counter (
        .clk_i,
        .multiple_i(head_multiple),
        .reciprocal_i(reciprocal[head]),
        .start_i(new_row),
        .start_phase_i(left_phase[head]),
        .step_i(compositing && covered),
        .phase_i(column_phase_next),
        .weight_o(weight_x)
    );
    blend_counter row_counter (
        .clk_i,
        .multiple_i(head_multiple),
        .reciprocal_i(reciprocal[head]),
        .start_i(starting),
        .start_phase_i(top_phase[head]),
        .step_i(compositing && raster_row_ends && row_covered),
        .phase_i(row_phase_next),
        .weight_o(weight_y)
    );
    pixel_blend blend (
        .own_i(own_is_second ? fifo_next_word : fifo_word),
        .beside_i(own_is_second ? fifo_word : fifo_next_word),
        .across_i(own_is_second ? fifo_row_next_word : fifo_row_word),
        .diagonal_i(own_is_second ? fifo_row_word : fifo_row_next_word),
        .weight_x_i(beside ? weight_x : '0),
        .weight_y_i(across ? weight_y : '0),
        .far_z_i,
        .alpha_key_i(composition_i == COMPOSE_Z_ALPHA_KEY),
        .pixel_o(blended)
    );
    blend_reciprocal table_of_reciprocals (
        .multiple_i(row_multiple),
        .reciprocal_o(row_reciprocal)
    );
    assign local_pixel = smooths ? blended : fifo_word;

    always_ff @(posedge clk_i) begin : window_registers
      beside <= beside_next;
      beside_is_left <= beside_is_left_next;
      across <= across_next;
      if (own_row) reciprocal[source_1] <= row_reciprocal;
    end
  end else begin : gen_replication
    assign local_pixel = fifo_word;
    logic unused_smoothing;
    assign unused_smoothing = ^{smoothing_i, far_z_i, fifo_next_word, fifo_row_word, fifo_row_next_word};
  end

  // ---- step 2: the bus side ----

  // A table row: words 0 and 1 of its beat.
  logic [63:0] row_word_0, row_word_1;
  logic [15:0] row_sdx, row_sdy, row_right, row_bottom;
  logic signed [15:0] row_dx, row_dy;
  assign row_word_0 = bus_words_i[63:0];
  assign row_word_1 = bus_words_i[127:64];
  assign row_sdx = row_word_0[63:48];
  assign row_sdy = row_word_1[15:0];
  assign row_dx = row_word_1[31:16];
  assign row_dy = row_word_1[47:32];
  assign row_multiple = row_word_1[55:48];

  // One past the last raster position that the segment covers in one direction.
  function automatic logic [15:0] clipped_end(input logic signed [15:0] from, input logic [15:0] source,
                                              input logic [7:0] multiple, input logic [15:0] raster);
    logic signed [25:0] end_position;
    end_position = 26'(from) + $signed({2'd0, {8'd0, source} * {16'd0, multiple}});
    if (end_position < 0) clipped_end = '0;
    else clipped_end = end_position < $signed({10'd0, raster}) ? end_position[15:0] : raster;
  endfunction

  assign row_right = clipped_end(row_dx, row_sdx, row_multiple, raster_width_i);
  assign row_bottom = clipped_end(row_dy, row_sdy, row_multiple, raster_height_i);

  // Repetitions of the first source line of an axis before the raster; of the second one, and bit 8 is set, if no
  // repetition of the first one is left.
  function automatic logic [8:0] outside_raster(input logic signed [15:0] from, input logic [7:0] multiple_of_row);
    logic [15:0] repetitions;
    logic apron;
    repetitions = from < 0 ? $unsigned(-from) : '0;
    apron = SMOOTHS && repetitions >= {8'd0, multiple_of_row};
    outside_raster = {apron, apron ? 8'(repetitions - {8'd0, multiple_of_row}) : repetitions[7:0]};
  endfunction

  logic row_left_apron, row_top_apron;
  logic [7:0] row_left_phase, row_top_phase;
  assign {row_left_apron, row_left_phase} = outside_raster(row_dx, row_multiple);
  assign {row_top_apron, row_top_phase} = outside_raster(row_dy, row_multiple);

  // A beat's frame number shows what was sent before its frame, and its index what was sent of its frame.
  logic beat, begins, goes_back, too_many, follows, newer, table_open, row_beat, taking_row, losing_table;
  logic signed [31:0] ahead;  // frames after the newest that is known
  logic [31:0] missed_count, heard_1;
  logic table_lost_1;
  logic beginning, table_ends;
  logic own_beat, dropping, in_order, keeping, losing, nothing_due, overfull;
  logic newest_2;
  logic [1:0] frames_2;
  logic [31:0] released_source, lost_count, arrived_2, arrived_3;
  logic [COUNT_BITS-1:0] held_2, held_3, free_2, free_3;
  logic [3:0] late_count, timely_count, taken_count;
  logic abandoned_2;
  logic [15:0] announced_1;
  logic [19:0] silent_cycles_1;
  logic [2:0] error_next;

  always_comb begin : take_beat
    error_next = ERROR_NONE;

    // The frame whose pixels come: the newest, even if it is over already.
    source_1 = frames_1 == 2'd2 || receiving_ended_1 ? !head_1 : head_1;
    nothing_due = frames_1 == 2'd0 && !receiving_ended_1;
    released_source = '0;
    if (receiving_ended_1) released_source = segment_pixels[source_1];
    else if (source_1 == head_1) released_source = released_1;

    beat = bus_kind_i != BUS_NONE;
    begins = bus_kind_i == BUS_FRAME_START;
    ahead = $signed(bus_frame_i - heard + 32'd1);
    goes_back = beat && (ahead < 0 || ahead > MOST_FRAMES_AHEAD || (begins && ahead == 0));
    too_many = begins && !goes_back && frames_1 == 2'd2;
    if (goes_back) error_next = ERROR_FRAME;
    if (too_many) error_next = ERROR_TABLES;
    follows = beat && !goes_back && !too_many;
    newer = follows && ahead > 0;
    heard_1 = newer ? bus_frame_i + 32'd1 : heard;
    missed_count = '0;
    if (newer) missed_count = begins ? $unsigned(ahead) - 32'd1 : $unsigned(ahead);

    table_open = frames_1 != 2'd0 && !table_complete[source_1];
    row_beat = follows && !newer && bus_kind_i == BUS_TABLE_ROW && !table_lost;
    taking_row = row_beat && table_open && bus_first_i == {16'd0, next_row};
    if (row_beat && (!table_open || bus_first_i < {16'd0, next_row})) error_next = ERROR_ROW;
    losing_table = table_open && (newer || (follows && bus_kind_i == BUS_PIXELS) ||
                                  (row_beat && bus_first_i > {16'd0, next_row}));
    table_lost_1 = table_lost || losing_table || missed_count != '0;

    beginning = begins && follows;
    frames_2 = beginning ? frames_1 + 2'd1 : frames_1;
    newest_2 = frames_2 == 2'd2 ? !head_1 : head_1;
    own_row = taking_row && bus_destination_i == display_i;
    table_ends = bus_last_i && (beginning || taking_row);

    own_beat = follows && bus_kind_i == BUS_PIXELS && bus_destination_i == display_i;
    dropping = own_beat && table_lost_1;
    in_order = own_beat && !dropping && !nothing_due && bus_first_i >= arrived[source_1];
    if (own_beat && !dropping && !in_order) error_next = nothing_due ? ERROR_NO_TABLE : ERROR_ORDER;

    // Pixels that were sent and have not come: before this beat, or before this frame.
    lost_count = '0;
    if (in_order) lost_count = bus_first_i - arrived[source_1];
    if (newer && !nothing_due && !table_open && has_segment[source_1] && segment_pixels[source_1] > arrived[source_1]) begin
      lost_count = segment_pixels[source_1] - arrived[source_1];
    end
    losing = lost_count != '0;
    arrived_2 = arrived[source_1] + lost_count;
    abandoned_2 = abandoned[source_1] || (losing && !receiving_ended_1);
    held_2 = held_1;
    if (abandoned_2 && !abandoned[source_1] && arrived[source_1] > released_source) begin
      held_2 = held_1 - COUNT_BITS'(arrived[source_1] - released_source);
    end
    free_2 = buffer_pixels_i - held_2;
    keeping = in_order && !abandoned_2;

    // The beat's first pixels may be later than their last use, and its last ones may find no room.
    late_count = '0;
    if (keeping && released_source > arrived_2) begin
      late_count = released_source - arrived_2 < {28'd0, bus_count_i} ? 4'(released_source - arrived_2) : bus_count_i;
    end
    timely_count = bus_count_i - late_count;
    overfull = keeping && COUNT_BITS'(timely_count) > free_2;
    if (overfull) error_next = ERROR_FULL;
    taken_count = overfull ? late_count + 4'(free_2) : bus_count_i;
    held_3 = held_2;
    if (overfull) held_3 = buffer_pixels_i;
    else if (keeping) held_3 = held_2 + COUNT_BITS'(timely_count);
    free_3 = buffer_pixels_i - held_3;
    arrived_3 = in_order ? arrived_2 + {28'd0, taken_count} : arrived_2;

    // What is announced and does not come is lost, or something other than this composer stopped its burst.
    announced_1 = announced_o;
    silent_cycles_1 = silent_cycles;
    if ((in_order && !overfull) || dropping) begin
      announced_1 = bus_remaining_i;
      silent_cycles_1 = '0;
    end else if (!own_beat && announced_o != '0) begin
      silent_cycles_1 = silent_cycles + 20'd1;
      if (silent_cycles_1 == longest_gap_cycles_i) announced_1 = '0;
    end
  end

  // The local memory is a ring of MAX_BUFFER_PIXELS, of which buffer_pixels_i are used at a time. The read is for the
  // raster position of the next edge.
  logic reading;
  logic [1:0] fifo_error;
  logic [COUNT_BITS-1:0] fifo_free;
  assign reading = running_next && covered_next;

  composer_fifo #(
      .MAX_PIXELS(MAX_BUFFER_PIXELS),
      .WINDOW_ROWS(WINDOW_ROWS)
  ) fifo (
      .clk_i,
      .reset_i,
      .capacity_i(buffer_pixels_i),
      .last_address_i({ADDRESS_BITS{1'b1}}),
      .write_count_i(keeping ? taken_count : 4'd0),
      .write_address_i(write_address),
      .write_words_i(bus_words_i),
      .read_i(reading),
      .read_address_i(window_address),
      .release_oldest_i(held - held_1 + (keeping ? COUNT_BITS'(late_count) : '0)),
      .release_newest_i(held_1 - held_2),
      .word_o(fifo_word),
      .next_word_o(fifo_next_word),
      .row_read_i(reading && across_next),
      .row_read_address_i(row_address),
      .row_word_o(fifo_row_word),
      .row_next_word_o(fifo_row_next_word),
      .level_o(held),
      .free_o(fifo_free),
      .error_o(fifo_error)
  );
  // These pins stay unused: the FIFO is never asked for more than it can do, and late pixels are released as they come.
  logic unused_fifo;
  assign unused_fifo = ^{fifo_free, fifo_error};

  // ---- step 3: the handshakes ----

  logic [15:0] announced_2;
  logic [4:0] cut_cycles, cut_cycles_1;  // in which beats of a burst may still come that BUSREADY has ended
  assign cutting_o = cut_cycles != '0;
  logic in_burst, cutting, falling, busready_next, head_fresh, head_complete, prefetched_next, missing_next;
  logic head_abandoned_next;
  logic head_loses_table, head_missed_next, table_complete_next;
  logic [31:0] oldest_kept, frames_known;
  logic [31:0] head_arrived_next;
  logic [SPACE_BITS-1:0] free_space, in_flight, room_wanted;

  always_comb begin : handshakes
    announced_2 = cut_cycles == 5'd1 ? '0 : announced_1;
    cut_cycles_1 = cut_cycles == '0 ? '0 : cut_cycles - 5'd1;
    in_burst = announced_2 > {12'd0, pixels_per_beat_i};
    free_space = SPACE_BITS'(free_3);
    in_flight = SPACE_BITS'(in_flight_pixels_i);
    room_wanted = SPACE_BITS'(announced_2);
    if (!in_burst) room_wanted = room_wanted + SPACE_BITS'(ready_space_pixels_i);
    else if (room_wanted > in_flight) room_wanted = in_flight;
    cutting = cut_cycles_1 != '0;
    falling = in_burst && !cutting && free_space < room_wanted;
    busready_next = !cutting && free_space >= room_wanted;

    // The head frame as the bus side leaves it.
    head_fresh = beginning && frames_1 == 2'd0;
    oldest_kept = head_fresh ? bus_frame_i : number[head_1];
    head_missed_next = composited_1 != (frames_2 != 2'd0 ? oldest_kept : heard_1);
    head_loses_table = losing_table && frames_1 == 2'd1;
    frames_known = heard_1 - composited_1;
    head_arrived_next = frames_1 == 2'd1 ? arrived_3 : arrived[head_1];
    head_abandoned_next = head_missed_next || head_loses_table ||
                          (frames_1 == 2'd1 ? abandoned_2 : abandoned[head_1]);
    head_complete = head_fresh || (!has_segment[head_1] && !(own_row && source_1 == head_1)) || head_abandoned_next ||
                    (has_segment[head_1] && head_arrived_next == segment_pixels[head_1]);
    table_complete_next = head_missed_next ||
                          (frames_2 != 2'd0 && ((table_ends && newest_2 == head_1) || head_loses_table ||
                                                (!head_fresh && table_complete[head_1])));
    prefetched_next = !running_next && table_complete_next && (head_complete || free_3 < ready_space_pixels_i);
    missing_next = running_next && covered_next && !head_abandoned_next && newest_next >= head_arrived_next;
  end

  // ---- the clock edge ----

  always_ff @(posedge clk_i) begin : control_registers
    if (reset_i) begin
      pipemaster <= pipemaster_i;
      head <= 1'b0;
      frames <= '0;
      heard <= '0;
      composited <= '0;
      table_lost <= 1'b0;
      next_row <= '0;
      receiving_ended <= 1'b0;
      released <= '0;
      write_address <= '0;
      running <= 1'b0;
      row_covered <= 1'b0;
      covered <= 1'b0;
      missing <= 1'b0;
      frame_o <= '1;
      busready_o <= 1'b0;
      tableready_o <= 1'b0;
      startframe_o <= 1'b0;
      pipe_pixel_o <= '0;
      pipe_valid_o <= 1'b0;
      pipe_lost_o <= 1'b0;
      pipeready_o <= 1'b0;
      stall_o <= 1'b0;
      announced_o <= '0;
      silent_cycles <= '0;
      composited_o <= 1'b0;
      starved_o <= 1'b0;
      replayed_o <= 1'b0;
      stalled_o <= 1'b0;
      cut_o <= 1'b0;
      cut_cycles <= '0;
      late_o <= '0;
      lost_o <= '0;
      lost_tables_o <= '0;
      error_o <= ERROR_NONE;
      prefetched_o <= 1'b0;
    end else begin
      head <= head_1;
      frames <= frames_2;
      heard <= heard_1;
      composited <= composited_1;
      table_lost <= table_lost_1 && !beginning;
      if (beginning) next_row <= '0;
      else if (taking_row) next_row <= next_row + 16'd1;
      receiving_ended <= receiving_ended_1 && !newer;
      released <= released_1;
      if (keeping) write_address <= write_address + ADDRESS_BITS'(taken_count);
      running <= running_next;
      row_covered <= row_covered_next;
      covered <= covered_next;
      missing <= missing_next;
      if (starting) frame_o <= frame_o + 32'd1;

      busready_o <= busready_next;
      tableready_o <= frames_known < 32'd2;
      if (moving) begin
        startframe_o <= starting;
        pipe_valid_o <= running;
        pipe_lost_o <= running && (upstream_lost || head_abandoned);
        if (!running) pipe_pixel_o <= '0;
        else pipe_pixel_o <= covered && !missing && !head_abandoned ? merged_pixel : upstream_pixel;
      end
      // A PIPEREADY from below that belongs to the frame just composited may still stand at the frame's last edge.
      pipeready_o <= !running_next && !running && !(moving ? starting : startframe_o) &&
                     (pipeready_o || (prefetched_next && pipeready_i));
      stall_o <= stall_mode_i && missing_next;
      announced_o <= announced_2;

      composited_o <= compositing;
      starved_o <= compositing && missing;
      replayed_o <= replaying;
      stalled_o <= !moving && stall_o;
      cut_o <= falling;
      cut_cycles <= falling ? cut_cycles_i : cut_cycles_1;
      late_o <= late_count;
      lost_o <= lost_count;
      lost_tables_o <= missed_count + {31'd0, losing_table};
      error_o <= error_next;
      prefetched_o <= prefetched_next;
      silent_cycles <= silent_cycles_1;
    end
  end

  always_ff @(posedge clk_i) begin : walk_registers
    x_o <= x_next;
    y_o <= y_next;
    column_o <= column_next;
    column_phase <= column_phase_next;
    row_phase_o <= row_phase_next;
    first_row_phase <= first_row_phase_next;
    row_first_pixel_o <= row_first_pixel_next;
    pixel_o <= newest_next;
    source_row <= source_row_next;
  end

  always_ff @(posedge clk_i) begin : frame_registers
    // The frame that a new table begins is never the one whose pixels or table are lost by it.
    if (in_order || losing) begin
      arrived[source_1] <= arrived_3;
      abandoned[source_1] <= abandoned_2;
    end
    if (losing_table) begin
      table_complete[source_1] <= 1'b1;
      has_segment[source_1] <= 1'b0;
      abandoned[source_1] <= 1'b1;
    end
    if (beginning) begin
      number[newest_2] <= bus_frame_i;
      table_complete[newest_2] <= 1'b0;
      has_segment[newest_2] <= 1'b0;
      abandoned[newest_2] <= 1'b0;
      arrived[newest_2] <= '0;
      base[newest_2] <= write_address;
    end
    if (own_row) begin
      has_segment[source_1] <= 1'b1;
      left[source_1] <= row_dx < 0 ? '0 : row_dx;
      left_phase[source_1] <= row_left_phase;
      left_apron[source_1] <= row_left_apron;
      right[source_1] <= row_right;
      top[source_1] <= row_dy < 0 ? '0 : row_dy;
      top_phase[source_1] <= row_top_phase;
      top_apron[source_1] <= row_top_apron;
      bottom[source_1] <= row_bottom;
      source_width[source_1] <= row_sdx;
      source_height[source_1] <= row_sdy;
      last_phase[source_1] <= row_multiple - 8'd1;
      segment_pixels[source_1] <= {16'd0, row_sdx} * {16'd0, row_sdy};
    end
    if (table_ends) table_complete[newest_2] <= 1'b1;
  end

  assign running_o = running;
  assign table_complete_o = head_missed || (frames != 2'd0 && table_complete[head]);
  assign expected_o = arrived[frames == 2'd2 || receiving_ended ? !head : head];
  assign held_o = held;

  // Fields of a table row that only the input framebuffer needs.
  logic unused;
  assign unused = &{1'b0, row_word_0[47:0], row_word_1[63:56]};
endmodule
