// A composer's walk over its display's raster. For each position it says which pixels of the segment show there, and
// which of them have then had their last use. Outputs named _next are of the position that the edge after this one
// composites.
module raster_walker #(
    parameter int WINDOW_ROWS   = 1,  // source rows in the window: 1, or 2 to smooth
    parameter int ADDRESS_BITS  = 12,
    parameter int POSITION_BITS = 16,
    parameter int MULTIPLE_BITS = 8,
    parameter int INDEX_BITS    = 32,
    parameter int FRAME_BITS    = 32
) (
    input logic clk_i,
    input logic reset_i,  // synchronous, active high

    input logic [POSITION_BITS-1:0] raster_width_i,
    input logic [POSITION_BITS-1:0] raster_height_i,
    input logic                     smoothing_i,

    input logic start_i,   // a frame starts at this edge
    input logic moving_i,  // the column does not stand still

    // The segment, as the receiver has it.
    input logic                     head_segment_i,
    input logic [POSITION_BITS-1:0] left_i,
    input logic [POSITION_BITS-1:0] right_i,
    input logic [POSITION_BITS-1:0] top_i,
    input logic [POSITION_BITS-1:0] bottom_i,
    input logic [POSITION_BITS-1:0] source_width_i,
    input logic [POSITION_BITS-1:0] source_height_i,
    input logic [INDEX_BITS-1:0]    segment_pixels_i,
    input logic [MULTIPLE_BITS-1:0] last_phase_i,
    input logic [MULTIPLE_BITS-1:0] left_phase_i,
    input logic [MULTIPLE_BITS-1:0] top_phase_i,
    input logic                     left_apron_i,
    input logic                     top_apron_i,
    input logic [22:0]              reciprocal_i,
    input logic [ADDRESS_BITS-1:0]  base_i,
    input logic [INDEX_BITS-1:0]    released_i,

    // The position that this edge composites, if it does.
    output logic       running_o,
    output logic       frame_ends_o,
    output logic       covered_o,
    output logic       again_o,          // its source row is shown for the second time or a later one
    output logic       smooths_o,
    output logic       own_is_second_o,  // of the two words of a row
    output logic [6:0] weight_x_o,
    output logic [6:0] weight_y_o,

    // What has had its last use then.
    output logic                  releases_o,
    output logic                  smoothed_releases_o,
    output logic [INDEX_BITS-1:0] release_end_o,

    // The next position, and where the FIFO has its pixels.
    output logic                    running_next_o,
    output logic                    covered_next_o,
    output logic [INDEX_BITS-1:0]   newest_next_o,  // of the pixels that it shows
    output logic                    across_next_o,  // it shows pixels of the other row, too
    output logic [ADDRESS_BITS-1:0] window_address_o,
    output logic [ADDRESS_BITS-1:0] row_address_o,

    // Status, as of the composer.
    output logic [FRAME_BITS-1:0]    frame_o,
    output logic [POSITION_BITS-1:0] x_o,
    output logic [POSITION_BITS-1:0] y_o,
    output logic [INDEX_BITS-1:0]    pixel_o,
    output logic [INDEX_BITS-1:0]    row_first_pixel_o,
    output logic [POSITION_BITS-1:0] column_o,
    output logic [MULTIPLE_BITS-1:0] row_phase_o
);
  localparam bit SMOOTHS = WINDOW_ROWS > 1;

  logic                     row_covered;
  logic [POSITION_BITS-1:0] source_row;       // that this raster row shows
  logic [MULTIPLE_BITS-1:0] column_phase;
  logic [MULTIPLE_BITS-1:0] first_row_phase;  // of the source row shown: not 0 only for one cut by the raster's top
  logic [INDEX_BITS-1:0]    own_pixel;        // of the segment, that the position shows

  // What the position is, compared when it was the next one.
  logic raster_row_ends;    // the last one of its raster row
  logic last_raster_row;    // the last raster row
  logic last_column_phase;  // the last one that shows its source column
  logic last_row_phase;     // the last raster row that shows its source row
  logic right_column;       // the last one of the segment in its raster row
  logic bottom_row;         // the last raster row of the segment
  logic right_column_next, bottom_row_next;

  // ---- the walk ----

  logic compositing, source_row_ends, last_use;
  assign compositing = moving_i && running_o;
  assign source_row_ends = compositing && raster_row_ends && row_covered && last_row_phase;
  assign frame_ends_o = compositing && raster_row_ends && last_raster_row;
  assign again_o = row_phase_o > first_row_phase;
  assign last_use = (last_row_phase || bottom_row) && (last_column_phase || right_column);
  assign releases_o = compositing && covered_o && last_use && !smooths_o;

  logic [POSITION_BITS-1:0] x_next, y_next, column_next;
  logic [MULTIPLE_BITS-1:0] column_phase_next, row_phase_next, first_row_phase_next;
  logic [INDEX_BITS-1:0] row_first_pixel_next, own_pixel_next;
  logic row_covered_next;
  logic [POSITION_BITS-1:0] source_row_next;

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
    own_pixel_next = own_pixel;
    if (start_i) begin
      x_next = '0;
      y_next = '0;
      column_next = POSITION_BITS'(left_apron_i);
      column_phase_next = left_phase_i;
      row_phase_next = top_phase_i;
      first_row_phase_next = top_phase_i;
      row_first_pixel_next = top_apron_i ? INDEX_BITS'(source_width_i) : '0;
      source_row_next = POSITION_BITS'(top_apron_i);
      row_covered_next = head_segment_i && top_i == '0 && bottom_i != '0;
    end else if (compositing) begin
      if (raster_row_ends) begin
        x_next = '0;
        y_next = y_o + POSITION_BITS'(1);
        column_next = POSITION_BITS'(left_apron_i);
        column_phase_next = left_phase_i;
        if (source_row_ends) begin
          row_phase_next = '0;
          first_row_phase_next = '0;
          row_first_pixel_next = row_first_pixel_o + INDEX_BITS'(source_width_i);
          source_row_next = source_row + POSITION_BITS'(1);
        end else if (row_covered) begin
          row_phase_next = row_phase_o + MULTIPLE_BITS'(1);
        end
        row_covered_next = head_segment_i && y_next >= top_i && y_next < bottom_i;
      end else begin
        x_next = x_o + POSITION_BITS'(1);
        if (covered_o) begin
          if (last_column_phase) begin
            column_phase_next = '0;
            column_next = column_o + POSITION_BITS'(1);
            own_pixel_next = own_pixel + INDEX_BITS'(1);
          end else begin
            column_phase_next = column_phase + MULTIPLE_BITS'(1);
          end
        end
      end
    end
    if (start_i || (compositing && raster_row_ends)) own_pixel_next = row_first_pixel_next + INDEX_BITS'(left_apron_i);
    running_next_o = start_i || (running_o && !frame_ends_o);
    covered_next_o = row_covered_next && x_next >= left_i && x_next < right_i;
    right_column_next = x_next == right_i - POSITION_BITS'(1);
    bottom_row_next = y_next == bottom_i - POSITION_BITS'(1);
  end

  // ---- smoothing ----

  // A replication factor of 1 leaves nothing to smooth.
  logic [MULTIPLE_BITS-1:0] multiple;
  logic [MULTIPLE_BITS-2:0] reach;  // raster pixels beyond its own block in which a source pixel is mixed
  assign smooths_o = SMOOTHS && smoothing_i && last_phase_i != '0;
  assign multiple = last_phase_i + MULTIPLE_BITS'(1);
  assign reach = multiple[MULTIPLE_BITS-1:1];

  // The next position's window: the own source pixel, one beside it in its row, one across it in another row, and the
  // one that is both. They lie on the side of the block's centre on which the raster pixel lies.
  logic [MULTIPLE_BITS:0] column_position, row_position;  // 2 phase + 1
  logic beside_is_left_next, across_is_above_next, beside_next;

  always_comb begin : window
    column_position = {column_phase_next, 1'b1};
    row_position = {row_phase_next, 1'b1};
    beside_is_left_next = column_position < {1'b0, multiple};
    across_is_above_next = row_position < {1'b0, multiple};
    beside_next = smooths_o && column_position != {1'b0, multiple} &&
                  (beside_is_left_next ? column_next != '0 : column_next != source_width_i - POSITION_BITS'(1));
    across_next_o = smooths_o && row_position != {1'b0, multiple} &&
                  (across_is_above_next ? source_row_next != '0
                                        : source_row_next != source_height_i - POSITION_BITS'(1));
    window_address_o = base_i + ADDRESS_BITS'(own_pixel_next) - ADDRESS_BITS'(beside_next && beside_is_left_next);
    row_address_o = across_is_above_next ? window_address_o - ADDRESS_BITS'(source_width_i)
                                       : window_address_o + ADDRESS_BITS'(source_width_i);
    newest_next_o = own_pixel_next + INDEX_BITS'(beside_next && !beside_is_left_next);
    if (across_next_o && !across_is_above_next) newest_next_o = newest_next_o + INDEX_BITS'(source_width_i);
  end

  // A source row is released in the last raster row that is mixed of it. At the bottom of the raster two may be in use
  // still: then the upper one is released pixel by pixel, and all others at the end.
  logic row_releases;
  logic [INDEX_BITS-1:0] last_use_end;  // what the position may release ends before this one

  always_comb begin : smoothed_release
    // At the start that is a row above the raster that nothing needs.
    release_end_o = smooths_o && start_i ? INDEX_BITS'(source_width_i) : last_use_end;
    smoothed_releases_o = smooths_o && release_end_o > released_i;
    if (start_i) begin
      smoothed_releases_o = smoothed_releases_o && head_segment_i && top_apron_i && top_phase_i >= {1'b0, reach};
    end else begin
      smoothed_releases_o = smoothed_releases_o && compositing && covered_o && row_releases &&
                          (right_column || (column_o != '0 && column_phase >= {1'b0, reach} - MULTIPLE_BITS'(1)));
    end
  end

  if (SMOOTHS) begin : gen_smoothing
    logic beside, beside_is_left, across;  // the window of the position composited now
    logic [6:0] weight_x, weight_y;
    assign own_is_second_o = beside && beside_is_left;
    assign weight_x_o = beside ? weight_x : '0;
    assign weight_y_o = across ? weight_y : '0;

    blend_counter column_counter (
        .clk_i,
        .multiple_i(8'(multiple)),
        .reciprocal_i,
        .start_i(start_i || (compositing && raster_row_ends)),
        .start_phase_i(8'(left_phase_i)),
        .step_i(compositing && covered_o),
        .phase_i(8'(column_phase_next)),
        .weight_o(weight_x)
    );
    blend_counter row_counter (
        .clk_i,
        .multiple_i(8'(multiple)),
        .reciprocal_i,
        .start_i,
        .start_phase_i(8'(top_phase_i)),
        .step_i(compositing && raster_row_ends && row_covered),
        .phase_i(8'(row_phase_next)),
        .weight_o(weight_y)
    );

    logic [INDEX_BITS-1:0] row_above_first_pixel, row_above_first_pixel_next;
    logic releases_row_above_next;
    always_comb begin : row_release
      row_above_first_pixel_next = row_above_first_pixel;
      if (start_i) row_above_first_pixel_next = '0;
      else if (source_row_ends) row_above_first_pixel_next = row_first_pixel_o;
      releases_row_above_next = source_row_next != '0 &&
                                (row_phase_next == {1'b0, reach} - MULTIPLE_BITS'(1) ||
                                 (bottom_row_next && row_phase_next < {1'b0, reach}));
    end

    always_ff @(posedge clk_i) begin : window_registers
      row_above_first_pixel <= row_above_first_pixel_next;
      row_releases <= releases_row_above_next || bottom_row_next;
      if (!smooths_o) last_use_end <= own_pixel_next + INDEX_BITS'(1);
      else if (right_column_next && bottom_row_next) last_use_end <= segment_pixels_i;
      else last_use_end <= (releases_row_above_next ? row_above_first_pixel_next : row_first_pixel_next) +
                           (right_column_next ? INDEX_BITS'(source_width_i) : INDEX_BITS'(column_next));
      beside <= beside_next;
      beside_is_left <= beside_is_left_next;
      across <= across_next_o;
    end
  end else begin : gen_replication
    assign own_is_second_o = 1'b0;
    assign weight_x_o = '0;
    assign weight_y_o = '0;
    assign row_releases = 1'b0;
    always_ff @(posedge clk_i) begin : window_registers
      last_use_end <= own_pixel_next + INDEX_BITS'(1);
    end
    logic unused_smoothing;
    assign unused_smoothing = ^{smoothing_i, reciprocal_i, segment_pixels_i};
  end

  // ---- the clock edge ----

  always_ff @(posedge clk_i) begin : control_registers
    if (reset_i) begin
      running_o <= 1'b0;
      row_covered <= 1'b0;
      covered_o <= 1'b0;
      frame_o <= '1;
    end else begin
      running_o <= running_next_o;
      row_covered <= row_covered_next;
      covered_o <= covered_next_o;
      if (start_i) frame_o <= frame_o + FRAME_BITS'(1);
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
    pixel_o <= newest_next_o;
    source_row <= source_row_next;
    own_pixel <= own_pixel_next;
    raster_row_ends <= x_next == raster_width_i - POSITION_BITS'(1);
    last_raster_row <= y_next == raster_height_i - POSITION_BITS'(1);
    last_column_phase <= column_phase_next == last_phase_i;
    last_row_phase <= row_phase_next == last_phase_i;
    right_column <= right_column_next;
    bottom_row <= bottom_row_next;
  end
endmodule
