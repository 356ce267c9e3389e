/* The handshakes of a whole machine without clocks: ROWS renderers with a bus each, COLUMNS displays with a pipeline
 * each, and the swap lock, by the rules of docs/design.md, in `stall` mode. Each bus, each column and each clock domain
 * goes on at a speed of its own. Spin proves the claim `live` and every assertion. MISTAKE=n breaks the rule that is
 * marked so.
 */
#ifndef MISTAKE
#define MISTAKE 0
#endif
#define ROWS 2
#define COLUMNS 2
#define RASTER 3               /* positions */
#define PIXELS(row) (3 - 2 * (row)) /* of a segment, from the raster's first position on */
#define BUFFER 2               /* pixels: fewer than a segment of the one bus, more than one of the other */
#define READY_SPACE 1          /* pixels */

#define COMPOSER (row * COLUMNS + column)

/* Composers: frames that are known and not over, pixels held, and pixels that have come of the frame that is composited
 * or is next. */
byte known[4];
byte held[4];
byte arrived[4];
bit PIPEREADY[4];

/* Buses: what is still to be sent of the frame under way. */
byte unsent[4];

/* Columns. */
bit running[2];
byte position[2];        /* on the raster */
bit PIPEREADY_BELOW[2];  /* of the output framebuffer */
bit FRAMEDONE[2];
bit swaplock_seen[2];    /* by the DVI clock */
bit level[2];            /* of the DVI clock: it has swapped */
bit level_seen[2];       /* by the core clock */
bit picture[2];          /* which one is shown */

#if MISTAKE == 1
#define TABLEREADY(composer) (known[composer] < 3)
#else
#define TABLEREADY(composer) (known[composer] < 2)
#endif
#if MISTAKE == 2
#define BUSREADY (true)
#else
#define BUSREADY (BUFFER - held[COMPOSER] >= READY_SPACE)
#endif
#if MISTAKE == 3
#define PREFETCHED(composer) (known[composer] > 0 && BUFFER - held[composer] < READY_SPACE - 1)
#else
#define PREFETCHED(composer) \
    (known[composer] > 0 && (arrived[composer] == PIXELS(composer / COLUMNS) || BUFFER - held[composer] < READY_SPACE))
#endif
#if MISTAKE == 4
#define PICTURE_IS_FREE (!FRAMEDONE[column])
#else
#define PICTURE_IS_FREE (!FRAMEDONE[column] && !level_seen[column])
#endif
#if MISTAKE == 5
#define SWAPLOCK (FRAMEDONE[0] || FRAMEDONE[1])
#else
#define SWAPLOCK (FRAMEDONE[0] && FRAMEDONE[1])
#endif

proctype bus(byte row) {
    byte column, next;
    do
    :: d_step {
           TABLEREADY(row * COLUMNS) && TABLEREADY(row * COLUMNS + 1) && unsent[row * COLUMNS] == 0 &&
               unsent[row * COLUMNS + 1] == 0 ->
           for (column : 0 .. COLUMNS - 1) {
               known[COMPOSER]++;
               assert(known[COMPOSER] <= 2);
               unsent[COMPOSER] = PIXELS(row)
           }
           column = 0
       }
    :: d_step {
           unsent[row * COLUMNS] + unsent[row * COLUMNS + 1] > 0 ->
           /* A pixel for the next composer from here on that is ready; others are passed over. */
           column = next;
           if
           :: unsent[COMPOSER] == 0 || !BUSREADY -> column = 1 - column
           :: else
           fi;
           if
           :: unsent[COMPOSER] > 0 && BUSREADY ->
                  unsent[COMPOSER]--;
                  held[COMPOSER]++;
                  assert(held[COMPOSER] <= BUFFER);
                  if
                  :: known[COMPOSER] == 1 -> arrived[COMPOSER]++
                  :: else
                  fi;
                  next = 1 - column
           :: else
           fi;
           column = 0
       }
    od
}

proctype pipeline(byte column) {
    byte row;
    do
    :: d_step {
           !running[column] && !PIPEREADY_BELOW[column] && PICTURE_IS_FREE -> PIPEREADY_BELOW[column] = 1
       }
    :: d_step {
           !running[column] && !PIPEREADY[COLUMNS + column] && PIPEREADY_BELOW[column] &&
               PREFETCHED(COLUMNS + column) ->
           PIPEREADY[COLUMNS + column] = 1
       }
    :: d_step {
           !running[column] && !PIPEREADY[column] && PIPEREADY[COLUMNS + column] && PREFETCHED(column) ->
           PIPEREADY[column] = 1
       }
    :: d_step { /* The PIPEMASTER answers its PIPEREADY with STARTFRAME. */
           PIPEREADY[column] ->
           assert(PIPEREADY[COLUMNS + column] && PIPEREADY_BELOW[column] && !FRAMEDONE[column] && !running[column]);
           PIPEREADY[column] = 0;
           PIPEREADY[COLUMNS + column] = 0;
           PIPEREADY_BELOW[column] = 0;
           running[column] = 1
       }
    :: d_step { /* A raster pixel, once every composer has its own; until then COLUMNSTALL. */
           running[column] && (position[column] >= PIXELS(0) || arrived[column] > position[column]) &&
               (position[column] >= PIXELS(1) || arrived[COLUMNS + column] > position[column]) ->
           for (row : 0 .. ROWS - 1) {
               if
               :: position[column] < PIXELS(row) -> held[COMPOSER]--
               :: else
               fi
           }
           position[column]++;
           if
           :: position[column] == RASTER ->
                  running[column] = 0;
                  position[column] = 0;
                  FRAMEDONE[column] = 1;
                  for (row : 0 .. ROWS - 1) {
                      known[COMPOSER]--;
                      /* What has come of the next frame. */
                      arrived[COMPOSER] = (known[COMPOSER] > 0 -> PIXELS(row) - unsent[COMPOSER] : 0)
                  }
           :: else
           fi;
           row = 0
       }
    od
}

/* A clock of the DVI outputs, which run in step; every second one starts a frame. */
active proctype dvi() {
    byte column;
    bit starts, swaplock;
    do
    :: d_step {
           starts = !starts;
           swaplock = SWAPLOCK;
           for (column : 0 .. COLUMNS - 1) {
               if
               :: starts && swaplock_seen[column] && !level[column] ->
                      assert(FRAMEDONE[column]);
                      level[column] = 1;
                      picture[column] = !picture[column]
               :: !swaplock_seen[column] -> level[column] = 0
               :: else
               fi;
               swaplock_seen[column] = swaplock;
               assert(picture[column] == picture[0])
           }
           swaplock = 0;
           column = 0
       }
    od
}

/* An edge of the core clock at the output framebuffers. */
active proctype core() {
    byte column;
    do
    :: d_step {
           for (column : 0 .. COLUMNS - 1) {
               if
               :: level_seen[column] -> FRAMEDONE[column] = 0
               :: else
               fi;
               level_seen[column] = level[column]
           }
           column = 0
       }
    od
}

init {
    atomic {
        run bus(0);
        run bus(1);
        run pipeline(0);
        run pipeline(1)
    }
}

/* All displays swap for ever, so no bus, composer, column or display waits for ever. */
ltl live { ([]<> (picture[0] == 0)) && ([]<> (picture[0] == 1)) }
