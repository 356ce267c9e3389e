// What the proofs of the composer assume and claim: a composer in SystemVerilog, its renderer's bus and its neighbours
// in the pipeline, which keep to docs/design.md and do as they like otherwise. Every input but the clock is a free
// choice.
//
// Outputs named bad_ must never be high, and those named seen_ must be reachable.
module composer_proof #(
    // The machine, see the scenario's keys.
    parameter int RASTER_WIDTH  = 2,
    parameter int RASTER_HEIGHT = 2,
    parameter int BUFFER_PIXELS = 4,
    parameter int READY_SPACE   = 2,
    parameter int BEAT_PIXELS   = 1,
    parameter int BURST_PIXELS  = 3,
    parameter int READ_LATENCY  = 0,
    parameter int STAGES        = 0,
    parameter int LONGEST_GAP   = 2,
    parameter bit STALL_MODE    = 0,
    parameter int WINDOW_ROWS   = 1,
    parameter bit LOSSES        = 0,  // beats may be lost

    // The composer's table row, where a frame has one.
    parameter int LEFT_OUT = 0,  // raster columns that it begins left of the raster
    parameter int TOP_OUT  = 0,
    parameter int LEFT_IN  = 0,  // or right of the raster's left
    parameter int SDX      = 2,
    parameter int SDY      = 2,
    parameter int MULTIPLE = 1,

    // The clocks in which the next frame must start, when bus and neighbours act as soon as they may, but for the
    // memory's pages. 0: no bound, and they may let the composer wait for ever.
    parameter int BOUND_CYCLES = 0,

    parameter int MAX_BUFFER_PIXELS = 4,
    parameter int POSITION_BITS     = 3,
    parameter int MULTIPLE_BITS     = 2,
    parameter int INDEX_BITS        = 5,
    parameter int FRAME_BITS        = 3,
    parameter int GAP_BITS          = 3
) (
    input logic clk_i,

    input logic       pipemaster_i,     // the strap, in reset
    input logic       starts_table_i,
    input logic       sends_row_i,
    input logic       row_is_own_i,
    input logic       row_is_last_i,
    input logic       grants_i,
    input logic       sends_beat_i,
    input logic [3:0] beat_pixels_i,
    input logic       sends_other_i,    // a beat for another composer
    input logic       loses_i,          // what is sent now
    input logic       starts_frame_i,   // the composer above
    input logic       below_is_ready_i,
    input logic       other_stalls_i,   // another composer of the column

    input logic                  watches_i,      // the frame whose table starts
    input logic [INDEX_BITS-1:0] watched_pixel_i,

    output logic bad_ready,     // PIPEREADY is taken back before STARTFRAME, or STARTFRAME comes without it
    output logic bad_error,     // a protocol error, a full buffer
    output logic bad_loss,      // pixels or tables count as lost, or as late in stall mode, or starve in it
    output logic bad_pixel,     // a raster position does not show what it should
    output logic bad_wait,      // no frame starts within the bound
    output logic bad_account,   // composer and environment count differently: makes the proofs of the others short

    output logic bad,
    output logic seen_start,
    output logic seen_cut,          // BUSREADY ends a burst
    output logic seen_full,
    output logic seen_next_fetched,  // pixels of the next frame come while one is composited
    output logic seen_replay,
    output logic seen_starved,
    output logic seen_stall,
    output logic seen_loss,
    output logic seen_lost_table,
    output logic seen_watched,
    output logic seen_refused_table  // TABLEREADY keeps a table waiting
);
  localparam int ADDRESS_BITS = $clog2(MAX_BUFFER_PIXELS);
  localparam int COUNT_BITS = ADDRESS_BITS + 1;
  localparam int DX = LEFT_IN - LEFT_OUT;
  localparam int DY = -TOP_OUT;
  localparam int SEGMENT_PIXELS = SDX * SDY;
  localparam int RASTER_PIXELS = RASTER_WIDTH * RASTER_HEIGHT;
  localparam int LOOP = READ_LATENCY + 2 * STAGES;
  localparam int IN_FLIGHT = (2 + LOOP) * BEAT_PIXELS;
  localparam int LEFT_BITS = INDEX_BITS;
  localparam bit PROMPT = BOUND_CYCLES != 0;
  // The watched pixel's colour. A sixteenth of it must not be rounded to nothing where a composer smooths.
  localparam int COLOUR_BITS = WINDOW_ROWS > 1 ? 8 : 1;

  localparam logic [1:0] BUS_NONE = 2'd0;
  localparam logic [1:0] BUS_FRAME_START = 2'd1;
  localparam logic [1:0] BUS_TABLE_ROW = 2'd2;
  localparam logic [1:0] BUS_PIXELS = 2'd3;

  logic running_reset = 1'b0;
  logic reset;
  always_ff @(posedge clk_i) running_reset <= 1'b1;
  assign reset = !running_reset;

  // ---- wires of the composer ----

  logic busready, tableready, startframe_in, startframe_out, pipeready_in, pipeready_out, stall, column_stall;
  logic [63:0] pixel_out;
  logic valid_out, lost_out;
  logic starved, replayed, stalled, cut, running;
  logic [3:0] late;
  logic [INDEX_BITS-1:0] lost, expected;
  logic [FRAME_BITS-1:0] lost_tables, frame_status;
  logic [2:0] error;
  logic [POSITION_BITS-1:0] x_status, y_status;
  logic [COUNT_BITS-1:0] held;

  // ---- the bus as it is sent ----

  logic [FRAME_BITS-1:0] bus_frame;   // that is to begin next
  logic                  in_table, has_row;
  logic                  next_row;    // a table has up to two rows
  logic [LEFT_BITS-1:0]  own_left;    // pixels of the segment that have not been sent
  logic                  bursting, burst_started;
  logic [LEFT_BITS-1:0]  burst_left, announced, announced_before;
  logic [3:0]            uncounted, table_uncounted;
  logic [GAP_BITS-1:0]   gap;
  logic                  busready_seen, tableready_seen;

  // A frame number needs no more than it takes to tell the frames that may be under way. The bus is ahead of this
  // composer by two frames at the most, for the column of any other one is.
  logic [FRAME_BITS-1:0] frames_over;

  logic starts, sends_row, own_row, row_ends, stops, in_burst_1, grants, in_burst, must_send, sends, other;
  logic [LEFT_BITS-1:0] burst_left_1, count;

  always_comb begin : bus_choices
    starts = (starts_table_i || PROMPT) && !in_table && own_left == '0 && !bursting && tableready_seen &&
             table_uncounted == '0 && bus_frame - frames_over <= FRAME_BITS'(2);
    sends_row = in_table && (sends_row_i || PROMPT);
    own_row = sends_row && row_is_own_i && !has_row;
    row_ends = row_is_last_i || (sends_row && next_row);
    stops = bursting && announced_before > LEFT_BITS'(BEAT_PIXELS) && !busready_seen;
    in_burst_1 = bursting && !stops;
    grants = (grants_i || PROMPT) && !in_table && !in_burst_1 && own_left != '0 && busready_seen && uncounted == '0;
    in_burst = in_burst_1 || grants;
    burst_left_1 = burst_left;
    if (grants) burst_left_1 = own_left < LEFT_BITS'(BURST_PIXELS) ? own_left : LEFT_BITS'(BURST_PIXELS);
    must_send = in_burst && gap == GAP_BITS'(LONGEST_GAP - 1) && (burst_started || PROMPT);
    sends = in_burst && (sends_beat_i || must_send);
    // A page may end within what would fit a beat.
    count = LEFT_BITS'(BEAT_PIXELS);
    if (count > burst_left_1) count = burst_left_1;
    if (beat_pixels_i != '0 && LEFT_BITS'(beat_pixels_i) < count) count = LEFT_BITS'(beat_pixels_i);
    other = sends_other_i && !PROMPT && !in_table && !in_burst && !starts;
  end

  logic [1:0]            sent_kind;
  logic                  sent_last, sent_own;
  logic [FRAME_BITS-1:0] sent_frame;
  logic [LEFT_BITS-1:0]  sent_count, sent_remaining;
  logic [INDEX_BITS-1:0] sent_first;

  always_comb begin : beat
    sent_kind = BUS_NONE;
    sent_last = row_ends;
    sent_own = own_row || sends;
    sent_frame = starts ? bus_frame : bus_frame - FRAME_BITS'(1);
    sent_count = count;
    sent_remaining = sends ? burst_left_1 - count : '0;
    sent_first = sends ? INDEX_BITS'(SEGMENT_PIXELS) - own_left : INDEX_BITS'(next_row && sends_row);
    if (starts) sent_kind = BUS_FRAME_START;
    if (sends_row) sent_kind = BUS_TABLE_ROW;
    if (sends || other) sent_kind = BUS_PIXELS;
    if (LOSSES && loses_i) sent_kind = BUS_NONE;
  end

  always_ff @(posedge clk_i) begin : bus_registers
    if (reset) begin
      bus_frame <= '0;
      in_table <= 1'b0;
      has_row <= 1'b0;
      own_left <= '0;
      bursting <= 1'b0;
      announced <= '0;
      uncounted <= '0;
      table_uncounted <= '0;
    end else begin
      if (uncounted != '0) uncounted <= uncounted - 4'd1;
      if (table_uncounted != '0) table_uncounted <= table_uncounted - 4'd1;
      if (starts) begin
        bus_frame <= bus_frame + FRAME_BITS'(1);
        in_table <= !row_ends;
        has_row <= 1'b0;
        next_row <= 1'b0;
        table_uncounted <= 4'(1 + LOOP);
      end
      if (sends_row) begin
        in_table <= !row_ends;
        next_row <= 1'b1;
        has_row <= has_row || own_row;
        if (own_row) own_left <= LEFT_BITS'(SEGMENT_PIXELS);
      end
      if (stops) begin
        bursting <= 1'b0;
        announced <= '0;
        if (LOOP > 0) uncounted <= 4'(LOOP);
      end
      if (grants) begin
        bursting <= 1'b1;
        burst_started <= 1'b0;
        burst_left <= burst_left_1;
      end
      gap <= in_burst ? gap + GAP_BITS'(1) : '0;
      if (sends) begin
        own_left <= own_left - count;
        burst_left <= burst_left_1 - count;
        announced <= burst_left_1 - count;
        burst_started <= 1'b1;
        gap <= '0;
        if (burst_left_1 == count) begin
          bursting <= 1'b0;
          if (grants || !burst_started || LOOP > 0) uncounted <= 4'(1 + LOOP);
        end
      end
    end
  end

  // What was announced when the composer wrote the BUSREADY that is read next.
  logic [LEFT_BITS-1:0] announced_line[LOOP+1];
  assign announced_line[0] = announced;
  for (genvar stage = 0; stage < LOOP; stage = stage + 1) begin : gen_announced
    always_ff @(posedge clk_i) announced_line[stage+1] <= reset || grants ? '0 : announced_line[stage];
  end
  always_ff @(posedge clk_i) announced_before <= reset || grants ? '0 : announced_line[LOOP];

  logic [STAGES:0] busready_line, tableready_line;
  assign busready_line[0] = busready;
  assign tableready_line[0] = tableready;
  for (genvar stage = 0; stage < STAGES; stage = stage + 1) begin : gen_ready
    always_ff @(posedge clk_i) begin
      busready_line[stage+1] <= !reset && busready_line[stage];
      tableready_line[stage+1] <= !reset && tableready_line[stage];
    end
  end
  assign busready_seen = busready_line[STAGES];
  assign tableready_seen = tableready_line[STAGES];

  // ---- the bus as it comes ----

  localparam int DELAY = 1 + READ_LATENCY + STAGES;
  localparam int BEAT_BITS = 4 + FRAME_BITS + 2 * LEFT_BITS + INDEX_BITS;
  logic [BEAT_BITS-1:0] beat_line[DELAY+1];
  assign beat_line[0] = {sent_kind, sent_last, sent_own, sent_frame, sent_count, sent_remaining, sent_first};
  for (genvar stage = 0; stage < DELAY; stage = stage + 1) begin : gen_beat
    always_ff @(posedge clk_i) beat_line[stage+1] <= reset ? '0 : beat_line[stage];
  end

  logic [1:0]            kind;
  logic                  last, own;
  logic [FRAME_BITS-1:0] frame;
  logic [LEFT_BITS-1:0]  beat_count, remaining;
  logic [INDEX_BITS-1:0] first;
  assign {kind, last, own, frame, beat_count, remaining, first} = beat_line[DELAY];

  // ---- the watched pixel: the only one with a colour ----

  logic watching, was_watched, watched_arrived;
  logic [FRAME_BITS-1:0] watched_frame;
  logic [INDEX_BITS-1:0] watched_pixel;
  logic [511:0] words;

  always_comb begin : bus_words
    words = '0;
    if (kind == BUS_TABLE_ROW) begin
      words[48 +: 16] = 16'(SDX);
      words[64 +: 16] = 16'(SDY);
      words[80 +: 16] = 16'(DX);
      words[96 +: 16] = 16'(DY);
      words[112 +: 8] = 8'(MULTIPLE);
    end else begin
      for (int word = 0; word < BEAT_PIXELS; word = word + 1) begin
        if (watching && frame == watched_frame && first + INDEX_BITS'(word) == watched_pixel)
          words[64*word +: COLOUR_BITS] = '1;
      end
    end
  end

  logic watched_comes;
  assign watched_comes = kind == BUS_PIXELS && own && watching && frame == watched_frame && first <= watched_pixel &&
                         watched_pixel < first + beat_count;

  // ---- the pipeline ----

  logic pipemaster, moving, above_sends, frame_starts, raster_ends;
  logic [POSITION_BITS-1:0] x, y;
  logic compositing;
  logic [FRAME_BITS-1:0] frame_composited;
  logic [2*POSITION_BITS-1:0] above_left, below_left;

  assign column_stall = stall || (other_stalls_i && !PROMPT);
  assign moving = !STALL_MODE || !column_stall;
  assign frame_starts = moving && (pipemaster ? pipeready_out : startframe_in);
  assign raster_ends = x == POSITION_BITS'(RASTER_WIDTH - 1) && y == POSITION_BITS'(RASTER_HEIGHT - 1);
  assign above_sends = pipeready_out && !startframe_in && above_left == '0 && (starts_frame_i || PROMPT);

  always_ff @(posedge clk_i) begin : pipeline
    if (reset) begin
      pipemaster <= pipemaster_i;
      startframe_in <= 1'b0;
      above_left <= '0;
      pipeready_in <= 1'b0;
      below_left <= '0;
      compositing <= 1'b0;
      frame_composited <= '1;
      frames_over <= '0;
    end else begin
      if (moving) begin
        startframe_in <= above_sends;
        if (startframe_in) above_left <= (2 * POSITION_BITS)'(RASTER_PIXELS - 1);
        else if (above_left != '0) above_left <= above_left - 1'b1;
      end
      if (moving && startframe_out) begin
        pipeready_in <= 1'b0;
        below_left <= (2 * POSITION_BITS)'(RASTER_PIXELS);
      end else if (below_left != '0) begin
        if (moving) below_left <= below_left - 1'b1;
      end else if (below_is_ready_i || PROMPT) begin
        pipeready_in <= 1'b1;
      end
      if (frame_starts) begin
        compositing <= 1'b1;
        frame_composited <= frame_composited + FRAME_BITS'(1);
        x <= '0;
        y <= '0;
      end else if (moving && compositing) begin
        x <= x + POSITION_BITS'(1);
        if (x == POSITION_BITS'(RASTER_WIDTH - 1)) begin
          x <= '0;
          y <= y + POSITION_BITS'(1);
        end
        if (raster_ends) begin
          compositing <= 1'b0;
          frames_over <= frames_over + FRAME_BITS'(1);
        end
      end
    end
  end

  // ---- what the raster should show ----

  // Whether a line of the raster shows a line of the segment; smoothed, whether it lies within a line's distance.
  function automatic logic shows(input logic signed [31:0] beyond, input int source);
    if (WINDOW_ROWS > 1) begin
      shows = 2 * beyond - MULTIPLE + 1 > 2 * (source - 1) * MULTIPLE &&
              2 * beyond - MULTIPLE + 1 < 2 * (source + 1) * MULTIPLE;
    end else begin
      shows = beyond >= source * MULTIPLE && beyond < (source + 1) * MULTIPLE;
    end
  endfunction

  logic covered, watched_covers, shows_watched, expected_watched, expected_valid;
  logic signed [31:0] beyond_x, beyond_y;

  always_comb begin : raster
    beyond_x = $signed(32'(x)) - DX;
    beyond_y = $signed(32'(y)) - DY;
    covered = beyond_x >= 0 && beyond_x < SDX * MULTIPLE && beyond_y >= 0 && beyond_y < SDY * MULTIPLE;
    watched_covers = 1'b0;
    for (int v = 0; v < SDY; v = v + 1) begin
      for (int u = 0; u < SDX; u = u + 1) begin
        if (watched_pixel == INDEX_BITS'(v * SDX + u) && shows(beyond_x, u) && shows(beyond_y, v)) watched_covers = covered;
      end
    end
    shows_watched = compositing && watched_covers && watching && frame_composited == watched_frame && watched_arrived;
  end

  always_ff @(posedge clk_i) begin : watch
    if (reset) begin
      watching <= 1'b0;
      was_watched <= 1'b0;
      watched_arrived <= 1'b0;
      expected_watched <= 1'b0;
      expected_valid <= 1'b0;
    end else begin
      if (starts && watches_i && !was_watched) begin
        watching <= 1'b1;
        was_watched <= 1'b1;
        watched_frame <= bus_frame;
        watched_pixel <= watched_pixel_i;
      end
      if (watched_comes) watched_arrived <= 1'b1;
      if (moving && compositing && raster_ends && frame_composited == watched_frame) watching <= 1'b0;
      if (moving) begin
        expected_watched <= shows_watched;
        expected_valid <= compositing;
      end
    end
  end

  // ---- what is claimed ----

  localparam int WAIT_BITS = $clog2(BOUND_CYCLES + 2);
  logic was_ready;
  logic [WAIT_BITS-1:0] waited;
  (* keep *) logic [1:0] fifo_error;  // connected to the composer's by scripts/prove
  always_ff @(posedge clk_i) begin : history
    was_ready <= !reset && pipeready_out && !frame_starts;
    waited <= reset || frame_starts ? '0 : waited + WAIT_BITS'(waited != '1);
  end

  assign bad_ready = !reset && ((was_ready && !pipeready_out) || (startframe_out && !pipeready_in));
  assign bad_error = !reset && (error != '0 || fifo_error != '0);
  assign bad_loss = !reset && ((!LOSSES && (lost != '0 || lost_tables != '0)) ||
                               (STALL_MODE && (late != '0 || starved)));
  // A lost frame passes what comes from above.
  logic seen_colour;
  assign seen_colour = pixel_out[COLOUR_BITS-1:0] != '0;
  assign bad_pixel = !reset && (valid_out != expected_valid || (seen_colour && !expected_watched) ||
                                (expected_watched && !seen_colour && !(LOSSES && lost_out)) || (!LOSSES && lost_out));
  assign bad_wait = !reset && BOUND_CYCLES != 0 && waited >= WAIT_BITS'(BOUND_CYCLES);
  logic [INDEX_BITS-1:0] coming;
  assign coming = kind == BUS_PIXELS && own ? INDEX_BITS'(beat_count) : '0;
  assign bad_account = !reset && (compositing != running || frame_composited != frame_status ||
                                  (running && (x != x_status || y != y_status)) || held > COUNT_BITS'(BUFFER_PIXELS) ||
                                  (!LOSSES && DELAY == 1 && !in_table && own_left != '0 && kind != BUS_TABLE_ROW &&
                                   expected + coming != INDEX_BITS'(SEGMENT_PIXELS) - own_left));
  assign bad = bad_ready || bad_error || bad_loss || bad_pixel || bad_account || bad_wait;

  assign seen_start = !reset && frame_starts;
  assign seen_cut = !reset && cut;
  assign seen_full = !reset && held == COUNT_BITS'(BUFFER_PIXELS);
  assign seen_next_fetched = !reset && compositing && kind == BUS_PIXELS && own && frame != frame_composited;
  assign seen_replay = !reset && replayed && seen_colour;
  assign seen_starved = !reset && starved;
  assign seen_stall = !reset && stalled;
  assign seen_loss = !reset && lost != '0;
  assign seen_lost_table = !reset && lost_tables != '0;
  assign seen_watched = !reset && seen_colour;
  assign seen_refused_table = !reset && starts_table_i && !in_table && own_left == '0 && !tableready_seen;

  composer #(
      .MAX_BUFFER_PIXELS(MAX_BUFFER_PIXELS),
      .WINDOW_ROWS(WINDOW_ROWS),
      .POSITION_BITS(POSITION_BITS),
      .MULTIPLE_BITS(MULTIPLE_BITS),
      .INDEX_BITS(INDEX_BITS),
      .FRAME_BITS(FRAME_BITS),
      .GAP_BITS(GAP_BITS)
  ) composer (
      .clk_i,
      .reset_i(reset),
      .display_i(16'd1),
      .raster_width_i(POSITION_BITS'(RASTER_WIDTH)),
      .raster_height_i(POSITION_BITS'(RASTER_HEIGHT)),
      .buffer_pixels_i(COUNT_BITS'(BUFFER_PIXELS)),
      .ready_space_pixels_i(COUNT_BITS'(READY_SPACE)),
      .pixels_per_beat_i(4'(BEAT_PIXELS)),
      .longest_gap_cycles_i(GAP_BITS'(LONGEST_GAP)),
      .in_flight_pixels_i(8'(IN_FLIGHT)),
      .cut_cycles_i(5'(1 + LOOP)),
      .composition_i(2'd0),
      .stall_mode_i(STALL_MODE),
      .smoothing_i(WINDOW_ROWS > 1),
      .far_z_i(24'h1),
      .background_i({8'd0, 24'h1, 32'd0}),
      .pipemaster_i,
      .bus_kind_i(kind),
      .bus_last_i(last),
      .bus_frame_i(frame),
      .bus_count_i(4'(beat_count)),
      .bus_destination_i(own ? 16'd1 : 16'd2),
      .bus_remaining_i(16'(remaining)),
      .bus_first_i(first),
      .bus_words_i(words),
      .busready_o(busready),
      .tableready_o(tableready),
      .startframe_i(startframe_in),
      .startframe_o(startframe_out),
      .pipe_pixel_i({8'd0, 24'h1, 32'd0}),
      .pipe_lost_i(1'b0),
      .pipe_pixel_o(pixel_out),
      .pipe_valid_o(valid_out),
      .pipe_lost_o(lost_out),
      .pipeready_i(pipeready_in),
      .pipeready_o(pipeready_out),
      .column_stall_i(column_stall),
      .stall_o(stall),
      .starved_o(starved),
      .replayed_o(replayed),
      .stalled_o(stalled),
      .cut_o(cut),
      .late_o(late),
      .lost_o(lost),
      .lost_tables_o(lost_tables),
      .error_o(error),
      .running_o(running),
      .frame_o(frame_status),
      .x_o(x_status),
      .y_o(y_status),
      .expected_o(expected),
      .held_o(held)
  );
endmodule
