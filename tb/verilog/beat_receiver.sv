// A composer's side of its renderer's bus. It takes the beats, keeps the account of frames and pixels, and says what
// may be sent. What the raster's edge releases comes before the edge's beat: outputs named _next are as both leave
// them.
module beat_receiver #(
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

    // Configuration, as of the composer.
    input logic [15:0]              display_i,
    input logic [POSITION_BITS-1:0] raster_width_i,
    input logic [POSITION_BITS-1:0] raster_height_i,
    input logic [COUNT_BITS-1:0]    buffer_pixels_i,
    input logic [COUNT_BITS-1:0]    ready_space_pixels_i,
    input logic [3:0]               pixels_per_beat_i,
    input logic [GAP_BITS-1:0]      longest_gap_cycles_i,
    input logic [7:0]               in_flight_pixels_i,
    input logic [4:0]               cut_cycles_i,

    // The bus of the renderer.
    input  logic [1:0]            bus_kind_i,
    input  logic                  bus_last_i,
    input  logic [FRAME_BITS-1:0] bus_frame_i,
    input  logic [3:0]            bus_count_i,
    input  logic [15:0]           bus_destination_i,
    input  logic [15:0]           bus_remaining_i,
    input  logic [INDEX_BITS-1:0] bus_first_i,
    input  logic [127:0]          bus_words_i,  // 0 and 1
    output logic                  busready_o,
    output logic                  tableready_o,

    // The raster: what this edge does.
    input logic                  frame_ends_i,
    input logic                  releases_i,           // of a replicated segment: the pixel before release_end_i
    input logic                  missing_i,            // which has not come
    input logic                  smoothed_releases_i,  // the pixels before release_end_i
    input logic [INDEX_BITS-1:0] release_end_i,

    // The frame that is composited, or is next. Segment bounds are clipped to the raster, end values one past the last.
    output logic                     head_segment_o,      // it shows on the raster
    output logic                     head_abandoned_o,
    output logic [POSITION_BITS-1:0] left_o,
    output logic [POSITION_BITS-1:0] right_o,
    output logic [POSITION_BITS-1:0] top_o,
    output logic [POSITION_BITS-1:0] bottom_o,
    output logic [POSITION_BITS-1:0] source_width_o,
    output logic [POSITION_BITS-1:0] source_height_o,
    output logic [INDEX_BITS-1:0]    segment_pixels_o,
    output logic [MULTIPLE_BITS-1:0] last_phase_o,        // replication factor - 1
    output logic [MULTIPLE_BITS-1:0] left_phase_o,        // repetitions of the raster's first source column left of it
    output logic [MULTIPLE_BITS-1:0] top_phase_o,         // repetitions of the raster's first source row above it
    output logic                     left_apron_o,        // the raster's first source column is the segment's second
    output logic                     top_apron_o,         // the same for its first row
    output logic [22:0]              reciprocal_o,        // of the replication factor, to smooth
    output logic [ADDRESS_BITS-1:0]  base_o,              // address of the segment's pixel 0
    output logic [INDEX_BITS-1:0]    released_o,          // pixels that have had their last use
    output logic                     head_abandoned_next_o,
    output logic [INDEX_BITS-1:0]    head_arrived_o,      // of its pixels, this beat's not counted
    output logic [3:0]               head_taken_count_o,  // of this beat
    output logic                     fetched_next_o,      // the frame can be composited

    // The FIFO, which writes the beat's words at this edge.
    input  logic [COUNT_BITS-1:0]   held_i,  // its level
    output logic [3:0]              write_count_o,
    output logic [ADDRESS_BITS-1:0] write_address_o,
    output logic [COUNT_BITS-1:0]   release_oldest_o,
    output logic [COUNT_BITS-1:0]   release_newest_o,

    // Status, as of the composer.
    output logic                  cut_o,
    output logic                  cutting_o,
    output logic [3:0]            late_o,
    output logic [INDEX_BITS-1:0] lost_o,
    output logic [FRAME_BITS-1:0] lost_tables_o,
    output logic [2:0]            error_o,
    output logic                  table_complete_o,
    output logic [INDEX_BITS-1:0] expected_o,
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

  localparam bit SMOOTHS = WINDOW_ROWS > 1;
  localparam int PRODUCT_BITS = POSITION_BITS + MULTIPLE_BITS;
  // Beyond the newest frame that is known: no bus gets there.
  localparam logic signed [FRAME_BITS-1:0] MOST_FRAMES_AHEAD =
      FRAME_BITS'(FRAME_BITS > 16 ? 65535 : (1 << (FRAME_BITS - 1)) - 1);
  localparam int SPACE_BITS = (COUNT_BITS > 16 ? COUNT_BITS : 16) + 1;  // counts and announced pixels together

  // Two frames: the one that is composited or is next to be (`head`), and the one after it on the bus. Segment bounds
  // are clipped to the raster, end values one past the last.
  logic [FRAME_BITS-1:0]    number[2];
  logic                     table_complete[2];  // or lost
  logic                     has_segment[2];
  logic                     abandoned[2];       // pixels or rows were lost: nothing of it is kept or waited for
  logic [POSITION_BITS-1:0] left[2];
  logic [POSITION_BITS-1:0] right[2];
  logic [POSITION_BITS-1:0] top[2];
  logic [POSITION_BITS-1:0] bottom[2];
  logic [POSITION_BITS-1:0] source_width[2];
  logic [MULTIPLE_BITS-1:0] last_phase[2];      // replication factor - 1
  logic [MULTIPLE_BITS-1:0] left_phase[2];      // repetitions of the raster's first source column left of it
  logic [MULTIPLE_BITS-1:0] top_phase[2];       // repetitions of the raster's first source row above it
  logic                     left_apron[2];      // the raster's first source column is the segment's second one
  logic                     top_apron[2];       // the same for its first row
  logic [POSITION_BITS-1:0] source_height[2];
  logic [INDEX_BITS-1:0]    segment_pixels[2];
  logic [INDEX_BITS-1:0]    arrived[2];
  logic [ADDRESS_BITS-1:0]  base[2];            // address of the segment's pixel 0
  logic                     head;
  logic [1:0]               frames;
  logic [FRAME_BITS-1:0]    frames_heard;       // number of the frame that is to begin next
  logic [FRAME_BITS-1:0]    composited;         // number of the frame that is composited or is next to be
  logic                     head_missed;        // its table did not come: it is abandoned, without a segment
  logic                     table_lost;         // of the newest frame: its pixels are dropped
  logic [POSITION_BITS-1:0] next_row;           // index of the table row that must come next
  logic                     receiving_ended;    // pixels of a frame that is over, not `head`, still come
  logic [ADDRESS_BITS-1:0]  write_address;
  logic [GAP_BITS-1:0]      silent_cycles;      // since the burst's last beat, while more of it is announced

  // ---- the raster's edge ----

  assign head_segment_o = frames != 2'd0 && has_segment[head] && !head_missed;
  assign head_abandoned_o = head_missed || (frames != 2'd0 && abandoned[head]);
  assign left_o = left[head];
  assign right_o = right[head];
  assign top_o = top[head];
  assign bottom_o = bottom[head];
  assign source_width_o = source_width[head];
  assign source_height_o = source_height[head];
  assign segment_pixels_o = segment_pixels[head];
  assign last_phase_o = last_phase[head];
  assign left_phase_o = left_phase[head];
  assign top_phase_o = top_phase[head];
  assign left_apron_o = left_apron[head];
  assign top_apron_o = top_apron[head];
  assign base_o = base[head];

  // The state that the frame's end leaves to the bus side.
  logic                  head_1;
  logic [1:0]            frames_1;
  logic [FRAME_BITS-1:0] composited_1;
  logic                  receiving_ended_1;
  logic [INDEX_BITS-1:0] released_1;
  logic [COUNT_BITS-1:0] freed;  // pixels of the buffer

  always_comb begin : release_pixels
    head_1 = head;
    frames_1 = frames;
    composited_1 = composited;
    receiving_ended_1 = receiving_ended;
    released_1 = released_o;
    freed = '0;
    if (smoothed_releases_i) begin
      released_1 = release_end_i;
      if (!head_abandoned_o && arrived[head] > released_o) begin
        freed = arrived[head] < release_end_i ? COUNT_BITS'(arrived[head] - released_o)
                                              : COUNT_BITS'(release_end_i - released_o);
      end
    end else if (releases_i) begin
      released_1 = release_end_i;
      freed = COUNT_BITS'(!missing_i && !head_abandoned_o);
    end
    if (frame_ends_i && head_missed) begin
      composited_1 = composited + FRAME_BITS'(1);
    end else if (frame_ends_i && frames != 2'd0) begin
      if (has_segment[head]) receiving_ended_1 = frames == 2'd1 && arrived[head] != segment_pixels[head];
      head_1 = !head;
      frames_1 = frames - 2'd1;
      composited_1 = composited + FRAME_BITS'(1);
      released_1 = '0;
    end
  end

  // ---- the bus's edge ----

  // A row for this composer, and whose frame it is of.
  logic own_row, receiving;
  logic [MULTIPLE_BITS-1:0] row_multiple;

  if (SMOOTHS) begin : gen_smoothing
    logic [22:0] reciprocal[2], row_reciprocal;
    assign reciprocal_o = reciprocal[head];
    blend_reciprocal table_of_reciprocals (
        .multiple_i(8'(row_multiple)),
        .reciprocal_o(row_reciprocal)
    );
    always_ff @(posedge clk_i) begin : reciprocal_registers
      if (own_row) reciprocal[receiving] <= row_reciprocal;
    end
  end else begin : gen_replication
    assign reciprocal_o = '0;
  end

  // A table row: words 0 and 1 of its beat.
  logic [63:0] row_word_0, row_word_1;
  logic [POSITION_BITS-1:0] row_sdx, row_sdy, row_right, row_bottom;
  logic signed [POSITION_BITS-1:0] row_dx, row_dy;
  assign row_word_0 = bus_words_i[63:0];
  assign row_word_1 = bus_words_i[127:64];
  assign row_sdx = row_word_0[48 +: POSITION_BITS];
  assign row_sdy = row_word_1[0 +: POSITION_BITS];
  assign row_dx = row_word_1[16 +: POSITION_BITS];
  assign row_dy = row_word_1[32 +: POSITION_BITS];
  assign row_multiple = row_word_1[48 +: MULTIPLE_BITS];

  // One past the last raster position that the segment covers in one direction.
  function automatic logic [POSITION_BITS-1:0] clipped_end(
      input logic signed [POSITION_BITS-1:0] from, input logic [POSITION_BITS-1:0] source,
      input logic [MULTIPLE_BITS-1:0] multiple, input logic [POSITION_BITS-1:0] raster);
    logic [PRODUCT_BITS-1:0] product;
    logic signed [PRODUCT_BITS+1:0] end_position;
    product = PRODUCT_BITS'(source) * PRODUCT_BITS'(multiple);
    end_position = (PRODUCT_BITS + 2)'(from) + $signed({2'd0, product});
    if (end_position < 0) clipped_end = '0;
    else if (end_position < $signed((PRODUCT_BITS + 2)'(raster))) clipped_end = end_position[POSITION_BITS-1:0];
    else clipped_end = raster;
  endfunction

  assign row_right = clipped_end(row_dx, row_sdx, row_multiple, raster_width_i);
  assign row_bottom = clipped_end(row_dy, row_sdy, row_multiple, raster_height_i);

  // Repetitions of the first source line of an axis before the raster; of the second one, with the high bit set, if no
  // repetition of the first one is left.
  function automatic logic [MULTIPLE_BITS:0] outside_raster(input logic signed [POSITION_BITS-1:0] from,
                                                            input logic [MULTIPLE_BITS-1:0] multiple_of_row);
    logic [POSITION_BITS-1:0] repetitions;
    logic apron;
    repetitions = from < 0 ? $unsigned(-from) : '0;
    apron = SMOOTHS && repetitions >= POSITION_BITS'(multiple_of_row);
    if (apron) repetitions = repetitions - POSITION_BITS'(multiple_of_row);
    outside_raster = {apron, repetitions[MULTIPLE_BITS-1:0]};
  endfunction

  logic row_left_apron, row_top_apron;
  logic [MULTIPLE_BITS-1:0] row_left_phase, row_top_phase;
  assign {row_left_apron, row_left_phase} = outside_raster(row_dx, row_multiple);
  assign {row_top_apron, row_top_phase} = outside_raster(row_dy, row_multiple);

  // A beat's frame number shows what was sent before its frame, and its index what was sent of its frame.
  logic beat, begins, goes_back, too_many, follows, newer, table_open, row_beat, taking_row, losing_table;
  logic signed [FRAME_BITS-1:0] ahead;  // frames after the newest that is known
  logic [FRAME_BITS-1:0] missed_count, frames_heard_1;
  logic table_lost_1;
  logic beginning, table_ends;
  logic pixel_beat, own_beat, dropping, in_order, keeping, cut_short, losing, nothing_due, overfull;
  logic newest_2;
  logic [1:0] frames_2;
  logic [INDEX_BITS-1:0] arrived_before, lost_count, arrived_3;
  logic [COUNT_BITS-1:0] free_1, free_2, free_3;
  logic [3:0] late_if_kept, late_count, taken_count, first_low;
  logic first_carry;
  logic [INDEX_BITS-5:0] first_high_up;
  logic newly_abandoned, abandoned_2;
  logic silence_ends;
  logic [2:0] error_next;

  // The frame whose pixels come: the newest, even if it is over already.
  assign receiving = frames == 2'd2 || receiving_ended ? !head : head;
  assign arrived_before = arrived[receiving];

  // How many pixels of a beat come too late, if those before `released` have had their last use.
  function automatic logic [3:0] too_late(input logic [INDEX_BITS-1:0] released, input logic [INDEX_BITS-1:0] first,
                                          input logic [3:0] count);
    logic [INDEX_BITS:0] difference;
    difference = {1'b0, released} - {1'b0, first};
    if (difference[INDEX_BITS]) too_late = '0;
    else too_late = difference < (INDEX_BITS + 1)'(count) ? difference[3:0] : count;
  endfunction

  always_comb begin : take_beat
    error_next = ERROR_NONE;
    nothing_due = frames_1 == 2'd0 && !receiving_ended_1;

    beat = bus_kind_i != BUS_NONE;
    begins = bus_kind_i == BUS_FRAME_START;
    ahead = $signed(bus_frame_i - frames_heard + FRAME_BITS'(1));
    goes_back = beat && (ahead < 0 || ahead > MOST_FRAMES_AHEAD || (begins && ahead == 0));
    too_many = begins && !goes_back && frames_1 == 2'd2;
    if (goes_back) error_next = ERROR_FRAME;
    if (too_many) error_next = ERROR_TABLES;
    follows = beat && !goes_back && !too_many;
    newer = follows && ahead > 0;
    frames_heard_1 = newer ? bus_frame_i + FRAME_BITS'(1) : frames_heard;
    missed_count = '0;
    if (newer) missed_count = begins ? $unsigned(ahead) - FRAME_BITS'(1) : $unsigned(ahead);

    table_open = frames_1 != 2'd0 && !table_complete[receiving];
    row_beat = follows && !newer && bus_kind_i == BUS_TABLE_ROW && !table_lost;
    taking_row = row_beat && table_open && bus_first_i == INDEX_BITS'(next_row);
    if (row_beat && (!table_open || bus_first_i < INDEX_BITS'(next_row))) error_next = ERROR_ROW;
    losing_table = table_open && (newer || (follows && bus_kind_i == BUS_PIXELS) ||
                                  (row_beat && bus_first_i > INDEX_BITS'(next_row)));
    table_lost_1 = table_lost || losing_table || missed_count != '0;

    beginning = begins && follows;
    frames_2 = beginning ? frames_1 + 2'd1 : frames_1;
    newest_2 = frames_2 == 2'd2 ? !head_1 : head_1;
    own_row = taking_row && bus_destination_i == display_i;
    table_ends = bus_last_i && (beginning || taking_row);

    // Pixels of the newest frame that is known, unless a part of its table is lost.
    pixel_beat = bus_kind_i == BUS_PIXELS && bus_destination_i == display_i;
    own_beat = pixel_beat && follows;
    dropping = own_beat && (table_lost || table_open || newer);
    in_order = pixel_beat && bus_frame_i + FRAME_BITS'(1) == frames_heard && !table_lost && !table_open &&
               !nothing_due && bus_first_i >= arrived_before;
    if (own_beat && !dropping && !in_order) error_next = nothing_due ? ERROR_NO_TABLE : ERROR_ORDER;

    // Pixels that were sent and have not come: before this beat, or before this frame.
    cut_short = newer && !nothing_due && !table_open && has_segment[receiving] &&
                segment_pixels[receiving] > arrived_before;
    lost_count = '0;
    if (in_order) lost_count = bus_first_i - arrived_before;
    if (cut_short) lost_count = segment_pixels[receiving] - arrived_before;
    losing = cut_short || (in_order && bus_first_i != arrived_before);
    newly_abandoned = losing && !receiving_ended_1 && !abandoned[receiving];
    abandoned_2 = abandoned[receiving] || newly_abandoned;
    keeping = in_order && !abandoned_2;

    // What the buffer holds of a frame that is abandoned is dropped. Of one frame, that is all.
    free_1 = buffer_pixels_i - held_i + freed;
    free_2 = free_1;
    if (newly_abandoned) free_2 = frames_1 == 2'd1 ? buffer_pixels_i : free_1 + COUNT_BITS'(arrived_before);

    // The beat's first pixels may be later than their last use, and its last ones may find no room.
    if (receiving_ended_1) late_if_kept = too_late(segment_pixels[receiving], bus_first_i, bus_count_i);
    else if (frames != 2'd1) late_if_kept = '0;
    else if (releases_i || smoothed_releases_i) late_if_kept = too_late(release_end_i, bus_first_i, bus_count_i);
    else late_if_kept = too_late(released_o, bus_first_i, bus_count_i);
    late_count = keeping ? late_if_kept : '0;
    overfull = keeping && (COUNT_BITS + 1)'(bus_count_i) > (COUNT_BITS + 1)'(free_1) + (COUNT_BITS + 1)'(late_if_kept);
    if (overfull) error_next = ERROR_FULL;
    taken_count = overfull ? late_if_kept + 4'(free_1) : bus_count_i;
    free_3 = free_2;
    if (overfull) free_3 = '0;
    else if (keeping) free_3 = free_1 - COUNT_BITS'(bus_count_i) + COUNT_BITS'(late_if_kept);
    // The high bits need no sum of all bits once the count is known.
    {first_carry, first_low} = {1'b0, bus_first_i[3:0]} + {1'b0, taken_count};
    first_high_up = bus_first_i[INDEX_BITS-1:4] + (INDEX_BITS - 4)'(1);
    if (!in_order) arrived_3 = segment_pixels[receiving];
    else arrived_3 = {first_carry ? first_high_up : bus_first_i[INDEX_BITS-1:4], first_low};
  end

  assign write_count_o = keeping ? taken_count : 4'd0;
  assign write_address_o = write_address;
  assign release_oldest_o = freed + COUNT_BITS'(late_count);
  assign release_newest_o = free_2 - free_1;

  // ---- BUSREADY, and the head frame as both leave it ----

  // The room that BUSREADY wants when so much is announced; and bit SPACE_BITS is set if a burst then goes on.
  function automatic logic [SPACE_BITS:0] room_for(input logic [15:0] announced, input logic [3:0] pixels_per_beat,
                                                   input logic [SPACE_BITS-1:0] ready_space,
                                                   input logic [7:0] in_flight);
    logic [SPACE_BITS-1:0] pixels;
    pixels = SPACE_BITS'(announced);
    if (announced <= {12'd0, pixels_per_beat}) room_for = {1'b0, pixels + ready_space};
    else room_for = {1'b1, announced <= {8'd0, in_flight} ? pixels : SPACE_BITS'(in_flight)};
  endfunction

  logic [15:0] announced_2;
  logic [SPACE_BITS-1:0] ready_space, room_wanted;
  logic taking_announced, in_burst;
  logic [GAP_BITS-1:0] silent_cycles_1;
  logic [4:0] cut_cycles, cut_cycles_1;  // in which beats of a burst may still come that BUSREADY has ended
  assign cutting_o = cut_cycles != '0;
  logic cutting, room, falling, busready_next, head_fresh, head_complete;
  logic head_loses_table, head_missed_next, table_complete_next;
  logic [FRAME_BITS-1:0] oldest_kept, frames_known;
  logic [INDEX_BITS-1:0] head_missing;

  always_comb begin : handshakes
    // What is announced and does not come is lost, or something other than this composer stopped its burst.
    silence_ends = !own_beat && announced_o != '0 && silent_cycles + GAP_BITS'(1) == longest_gap_cycles_i;
    taking_announced = (in_order && !overfull) || dropping;
    ready_space = SPACE_BITS'(ready_space_pixels_i);
    if (cut_cycles == 5'd1 || silence_ends) begin
      announced_2 = '0;
      {in_burst, room_wanted} = {1'b0, ready_space};
    end else if (taking_announced) begin
      announced_2 = bus_remaining_i;
      {in_burst, room_wanted} = room_for(bus_remaining_i, pixels_per_beat_i, ready_space, in_flight_pixels_i);
    end else begin
      announced_2 = announced_o;
      {in_burst, room_wanted} = room_for(announced_o, pixels_per_beat_i, ready_space, in_flight_pixels_i);
    end
    silent_cycles_1 = silent_cycles;
    if (taking_announced) silent_cycles_1 = '0;
    else if (!own_beat && announced_o != '0) silent_cycles_1 = silent_cycles + GAP_BITS'(1);
    cut_cycles_1 = cut_cycles == '0 ? '0 : cut_cycles - 5'd1;
    cutting = cut_cycles_1 != '0;
    room = SPACE_BITS'(free_3) >= room_wanted;
    falling = in_burst && !cutting && !room;
    busready_next = !cutting && room;

    // The head frame as the bus side leaves it.
    head_fresh = beginning && frames_1 == 2'd0;
    oldest_kept = head_fresh ? bus_frame_i : number[head_1];
    head_missed_next = composited_1 != (frames_2 != 2'd0 ? oldest_kept : frames_heard_1);
    head_loses_table = losing_table && frames_1 == 2'd1;
    frames_known = frames_heard_1 - composited_1;
    head_taken_count_o = frames_1 == 2'd1 ? write_count_o : '0;
    head_arrived_o = arrived[head_1];
    head_abandoned_next_o = head_missed_next || head_loses_table ||
                            (frames_1 == 2'd1 ? abandoned_2 : abandoned[head_1]);
    head_missing = segment_pixels[head_1] - arrived[head_1];
    head_complete = head_fresh || (!has_segment[head_1] && !(own_row && receiving == head_1)) ||
                    head_abandoned_next_o || (has_segment[head_1] && head_missing == INDEX_BITS'(head_taken_count_o));
    table_complete_next = head_missed_next ||
                          (frames_2 != 2'd0 && ((table_ends && newest_2 == head_1) || head_loses_table ||
                                                (!head_fresh && table_complete[head_1])));
    fetched_next_o = table_complete_next && (head_complete || free_3 < ready_space_pixels_i);
  end

  // ---- the clock edge ----

  always_ff @(posedge clk_i) begin : control_registers
    if (reset_i) begin
      head <= 1'b0;
      head_missed <= 1'b0;
      frames <= '0;
      frames_heard <= '0;
      composited <= '0;
      table_lost <= 1'b0;
      next_row <= '0;
      receiving_ended <= 1'b0;
      released_o <= '0;
      write_address <= '0;
      busready_o <= 1'b0;
      tableready_o <= 1'b0;
      announced_o <= '0;
      silent_cycles <= '0;
      cut_o <= 1'b0;
      cut_cycles <= '0;
      late_o <= '0;
      lost_o <= '0;
      lost_tables_o <= '0;
      error_o <= ERROR_NONE;
    end else begin
      head <= head_1;
      head_missed <= head_missed_next;
      frames <= frames_2;
      frames_heard <= frames_heard_1;
      composited <= composited_1;
      table_lost <= table_lost_1 && !beginning;
      if (beginning) next_row <= '0;
      else if (taking_row) next_row <= next_row + POSITION_BITS'(1);
      receiving_ended <= receiving_ended_1 && !newer;
      released_o <= released_1;
      if (keeping) write_address <= write_address + ADDRESS_BITS'(taken_count);
      busready_o <= busready_next;
      tableready_o <= frames_known < FRAME_BITS'(2);
      announced_o <= announced_2;
      silent_cycles <= silent_cycles_1;
      cut_o <= falling;
      cut_cycles <= falling ? cut_cycles_i : cut_cycles_1;
      late_o <= late_count;
      lost_o <= lost_count;
      lost_tables_o <= missed_count + FRAME_BITS'(losing_table);
      error_o <= error_next;
    end
  end

  always_ff @(posedge clk_i) begin : frame_registers
    // The frame that a new table begins is never the one whose pixels or table are lost by it.
    if (in_order || losing) begin
      arrived[receiving] <= arrived_3;
      abandoned[receiving] <= abandoned_2;
    end
    if (losing_table) begin
      table_complete[receiving] <= 1'b1;
      has_segment[receiving] <= 1'b0;
      abandoned[receiving] <= 1'b1;
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
      has_segment[receiving] <= 1'b1;
      left[receiving] <= row_dx < 0 ? '0 : row_dx;
      left_phase[receiving] <= row_left_phase;
      left_apron[receiving] <= row_left_apron;
      right[receiving] <= row_right;
      top[receiving] <= row_dy < 0 ? '0 : row_dy;
      top_phase[receiving] <= row_top_phase;
      top_apron[receiving] <= row_top_apron;
      bottom[receiving] <= row_bottom;
      source_width[receiving] <= row_sdx;
      source_height[receiving] <= row_sdy;
      last_phase[receiving] <= row_multiple - MULTIPLE_BITS'(1);
      segment_pixels[receiving] <= INDEX_BITS'(row_sdx) * INDEX_BITS'(row_sdy);
    end
    if (table_ends) table_complete[newest_2] <= 1'b1;
  end

  assign table_complete_o = head_missed || (frames != 2'd0 && table_complete[head]);
  assign expected_o = arrived_before;

  // Fields of a table row that only the input framebuffer needs.
  logic unused;
  assign unused = ^{row_word_0, row_word_1};
endmodule
