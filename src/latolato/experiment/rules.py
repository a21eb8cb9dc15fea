"""Sentences of measurements: verdicts and doubts of fits, warnings of tracking, notes of trials.

The pages translate a sentence by its name, as those of `latolato.core.rules`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

from latolato.core.errors import Sentence
from latolato.core.rules import Rule, broken_rule, sentence

_BALL = "point at the middle of the ball that swings, or give its radius and length"
RULES = {
    # lists in words
    "and_last": Rule("{others} and {last}"),
    "others": Rule("{count} others"),
    # of any fit
    "withheld": Rule("No number of this fit is a result."),
    "withheld_whole": Rule(
        "No number of this fit is a result: give {@start} and {@end} to fit a part that the model "
        "describes."
    ),
    "inspected": Rule("Its values are kept for inspection."),
    "outliers": Rule("{count} outliers were left out."),
    "repeated_samples": Rule("{count} samples that repeat the one before were left out."),
    "unusual_length": Rule(
        "This is the period of a pendulum of {value:.3g} m: is the clock in seconds, not in frames "
        "or milliseconds?"
    ),
    "unusual_drive_frequency": Rule(
        "A drive frequency of {value:.4g} rad/s is unusual: is the clock in seconds, not in frames "
        "or milliseconds?"
    ),
    "unusual_drive_amplitude": Rule(
        "A drive amplitude of {value:.4g} m is unusual: is the height in metres, not in "
        "millimetres or pixels?"
    ),
    "whole_turn": Rule("a whole turn"),
    "half_turn": Rule("half a turn"),
    "angle_rad": Rule("{angle:.3g} rad"),
    # doubts of any fit
    "scatters": Rule(
        "The model does not describe this record: the samples scatter about it by {ratio:.2g} "
        "times their noise."
    ),
    "far_samples": Rule(
        "The model does not describe this record: {share:.2g} % of its samples, the first at "
        "{time:.4g} s, lie far from it."
    ),
    "turned_samples": Rule(
        "The model does not describe this record: {share:.2g} % of its samples, the first at "
        "{time:.4g} s, lie far from it, by {turn}."
    ),
    "pivot_above": Rule(
        "The fit is not to be believed: it puts the pivot {share:.2g} of the arm above where the "
        "table has it, {times:.2g} times the uncertainty that the table states."
    ),
    "pivot_beside": Rule(
        "The fit is not to be believed: it puts the pivot {share:.2g} of the arm beside where the "
        "table has it, {times:.2g} times the uncertainty that the table states."
    ),
    # of a free swing
    "equation_gives": Rule("With {law} drag the equation gives {numbers}."),
    "small_period": Rule("a period of {period} for small swings"),
    "growing_swing": Rule("a swing that grows by {rate}"),
    "no_drag": Rule("no drag within its error (decay rate below {rate:.2g} 1/s)"),
    "no_damping": Rule(
        "no drag within its error (decay rate below {rate:.2g} 1/s, C below {damping:.2g} kg m/s)"
    ),
    "decay_rate_is": Rule("decay rate {rate}"),
    "dynamic_length": Rule(
        "length from the dynamics {length} (of a point, with g = {gravity:g} m/s² taken as exact)"
    ),
    "declared_length": Rule(
        "The declared length {length:g} m is {share} the dynamics give: check the length, gravity, "
        "the clock (frame rate, slow motion), or the mass of the rod."
    ),
    "percent_less": Rule("{percent:.2g} % less than"),
    "percent_more": Rule("{percent:.2g} % more than"),
    "times_what": Rule("{ratio:.2g} times what"),
    "no_law": Rule("The {count} drag laws could not be compared: none of their fits converged."),
    "only_law": Rule("{law} drag alone was fitted{excluded}."),
    "best_law": Rule(
        "{law} drag describes this decay best (BIC {ahead:.3g} ahead of {rival}){excluded}."
    ),
    "alike_laws": Rule("{laws} and {last} drag cannot be told apart{excluded}."),
    "excluded_law": Rule("; {law} drag alone is excluded"),
    "excluded_laws": Rule("; {laws} or {last} drag alone is excluded"),
    "excluded_choice": Rule("Do not trust the numbers of {law} drag then: use law 'best'."),
    "law_not_compared": Rule(
        "Of the {count} drag laws tried, {laws} is not compared: its fit did not converge."
    ),
    "laws_not_compared": Rule(
        "Of the {count} drag laws tried, {laws} are not compared: their fits did not converge."
    ),
    "lost_law": Rule(
        "The fit with {law} drag did not converge: these are the numbers for {chosen} drag."
    ),
    "envelope_lost": Rule("The fit of the envelope did not converge."),
    "envelope_short": Rule("{count} turning points are too few for an envelope."),
    "envelope_gives": Rule("The envelope gives a decay rate of {rate}{damping}{comparison}."),
    "envelope_unsure": Rule(", which is too uncertain to compare"),
    "envelope_agrees": Rule(", which agrees with the equation"),
    "envelope_differs": Rule(", which does not agree with the equation"),
    "only_turning_points": Rule(
        "The samples are turning points only, and the equation needs those between them."
    ),
    "few_in_swing": Rule("{count:.2g} samples in a swing are too few to see its turning points."),
    "same_look": Rule(
        "At one sample every {pause:.3g} s a period of {period:.3g} s would look the same."
    ),
    "freed": Rule("It is fitted from {time:.4g} s on, where the ball begins to swing freely."),
    "open_gap": Rule(
        "The record does not tell how many swings there were in its gap at {time:.4g} s: several "
        "lengths describe it equally well."
    ),
    "nearly_described": Rule(
        "Before and after {time:.4g} s the numbers differ by more than noise: the equation is "
        "{percent:.1g} % of the swing off. Their deviations include that."
    ),
    "not_described": Rule("The equation does not describe this record{scatter}."),
    "scatter_size": Rule(" (scatter {ratio:.2g} times the noise of the samples)"),
    "other_equation": Rule("The equation does not describe this record: {reason}."),
    "broken_record": Rule(
        "The equation does not describe this record{scatter}: it fails from {time:.4g} s on, and "
        "it looks as if {reason}."
    ),
    "seems_swing_in_radians": Rule(
        "It swings as a pendulum does at {size:.3g} rad, not at {size:.3g}°: are the angles in "
        "radians, and their unit wrong?"
    ),
    "seems_swing_in_degrees": Rule(
        "It swings as a pendulum does at {size:.3g}°, not at {size:.3g} rad: are the angles in "
        "degrees, and their unit wrong? If not, it is no pendulum."
    ),
    "other_drag": Rule("its drag is not {law} but rather {other}: use law 'best'{growth}"),
    "grows_at": Rule("; the swing grows by {rate:.3g} 1/s"),
    "missing_piece": Rule(
        "the swing jumps ahead by {share:.2g} of a period there: a piece of {lost} seems to be "
        "missing from the clock"
    ),
    "other_pace": Rule(
        "from there on everything happens {pace}: slow motion, another frame rate, or another "
        "length"
    ),
    "times_as_fast": Rule("{ratio:.3g} times as fast"),
    "times_as_slowly": Rule("{ratio:.3g} times as slowly"),
    "percent_faster": Rule("{percent:.2g} % faster"),
    "percent_slower": Rule("{percent:.2g} % more slowly"),
    "changed_drag": Rule(
        "the decay rate changes there from {drag_before:.3g} to {drag_after:.3g} 1/s"
    ),
    "shifted_angle": Rule("the angle shifts there by {offset}"),
    "two_films": Rule(
        "the swing changes there at once, by {share:.2g} of a period and from {size_before:.3g} to "
        "{size_after:.3g} rad: two films were joined, something touched the ball, or another ball "
        "is followed"
    ),
    "other_rest": Rule(
        "the ball hangs elsewhere from there on, by {offset}: a wind, or a pivot that slipped"
    ),
    "other_motion": Rule(
        "another motion begins there{other}: two films were joined, the film's pace changes, or "
        "the pendulum was changed"
    ),
    "other_period": Rule(", with a period of {after:.4g} s instead of {before:.4g} s"),
    # of a drive
    "drive_moves": Rule("The pivot moves with A0 = {amplitude} at {rate} ({turns}){later}{ramp}."),
    "drive_stage": Rule(", from {time} at {rate} ({turns})"),
    "drive_ramp": Rule(", each reached within {ramp}"),
    "crank_above": Rule(
        "The second harmonic ({share:.2g} % of the amplitude) matches a crank with A0/L = {ratio} "
        "and its guide above."
    ),
    "crank_below": Rule(
        "The second harmonic ({share:.2g} % of the amplitude) matches a crank with A0/L = {ratio} "
        "and its guide below."
    ),
    "no_crank": Rule("A second harmonic of {share:.2g} % of the amplitude does not match a crank."),
    "no_harmonic": Rule("No second harmonic was detected (below {share:.2g} %)."),
    "out_of_phase": Rule("It is not in phase, so a crank alone does not explain it."),
    "omitted_harmonic": Rule("The schedule of frequencies omits it."),
    "no_horizontal": Rule("No horizontal motion was detected ({size})."),
    "horizontal_ahead": Rule(
        "Horizontally it moves with {size}, {lead} ahead of the height{left}."
    ),
    "horizontal_behind": Rule("Horizontally it moves with {size}, {lead} behind the height{left}."),
    "left_out_by": Rule(", which the drive {drive} leaves out"),
    "unsteady_amplitude": Rule(
        "It is not steady: over {span:.3g} s its amplitude changes by {amplitude:.2g} %."
    ),
    "unsteady_frequency": Rule(
        "It is not steady: over {span:.3g} s its frequency changes by {frequency:.2g} %."
    ),
    "unsteady_both": Rule(
        "It is not steady: over {span:.3g} s its amplitude changes by {amplitude:.2g} % and its "
        "frequency changes by {frequency:.2g} %."
    ),
    "steady_drive": Rule("It is steady."),
    "scale_apart": Rule(
        "The uncertainty of the amplitude does not include that of the scale, which all heights "
        "share."
    ),
    "scale_included": Rule(
        "The uncertainty of the amplitude includes that of the scale ({percent:.1g} %), which all "
        "heights share."
    ),
    "drive_same_look": Rule(
        "At {rate:.4g} evenly spaced frames a second, a pivot at {one:.4g}, {other:.4g} or "
        "{third:.4g} Hz would look the same."
    ),
    "broken_drive": Rule(
        "A drive of {stages} stages does not describe the pivot's motion (scatter {ratio:.2g} "
        "times the noise of the samples): it fails from {time:.4g} s on{reason}."
    ),
    "broken_harmonic": Rule(
        "A drive of one frequency does not describe the pivot's motion (scatter {ratio:.2g} times "
        "the noise of the samples): it fails from {time:.4g} s on{reason}."
    ),
    "looks_as_if": Rule(", and it looks as if {reason}"),
    "drive_phase_jump": Rule(
        "its phase jumps ahead by {share:.2g} of a period there: a piece of the clock is missing, "
        "or two films were joined"
    ),
    "drive_pace": Rule(
        "its frequency changes there by {pace}: another speed, or another pace of the film"
    ),
    "drive_size": Rule("its amplitude changes there from {size_before:.3g} to {size_after:.3g} mm"),
    "drive_shift": Rule("its middle shifts there by {offset:.3g} mm"),
    "drive_other": Rule(
        "another motion begins there: two films were joined, or the drive was changed"
    ),
    # of a model
    "model_gives": Rule("The fit gives {values}."),
    "one_piece": Rule("The angle is described to {scatter:.3g} mrad in one piece."),
    "pieces": Rule(
        "The angle is described to {scatter:.3g} mrad in {count} pieces, each with its own start."
    ),
    "lost_one_piece": Rule("The fit in one piece did not converge."),
    "lost_pieces": Rule("The fit in {count} pieces did not converge."),
    "lost_pivots": Rule(
        "{count} of the fits that propagate the pivot's uncertainty did not converge: the standard "
        "deviations are too small."
    ),
    "changed_model": Rule(
        "The model does not describe this record: it fails from {time:.4g} s on, where other "
        "numbers describe it better."
    ),
    "contradicted_prior": Rule(
        "The samples contradict the prior of {name}: they alone give {value}, {times:.2g} standard "
        "deviations from the value that was given."
    ),
    "followed_whole": Rule(
        "The computed motion follows the measured one for all {span:.4g} s: they differ by "
        "{off:.3g} mrad (rms){noise}{phase}."
    ),
    "followed_noise": Rule(", {ratio:.2g} times the noise of the samples"),
    "followed_phase": Rule(", in phase by {phase:.2g} rad in the last third"),
    "followed_until": Rule(
        "The computed motion follows the measured one until {until:.4g} s of {last:.4g} s; later "
        "they differ by {off:.3g} mrad (rms)."
    ),
    "last_third": Rule("The largest angle of the last third is {measured}°, computed {computed}°."),
    # of impacts
    "restitution_balls": Rule("e = {value} from {count} impacts of two balls{scatter}{speed}."),
    "restitution_wall": Rule(
        "e = {value} from {count} impacts of one ball and a wall{scatter}{speed}."
    ),
    "impacts_differ": Rule("; they differ by {extra:.2g}, more than their uncertainty"),
    "restitution_falls": Rule("; e falls by {slope:.2g} for each rad/s of closing speed"),
    "restitution_grows": Rule("; e grows by {slope:.2g} for each rad/s of closing speed"),
    "smooth_reversals": Rule("{count} further reversals show no measurable impact."),
    "balls_faster": Rule(
        "Between impacts the balls swing {percent:.2g} % faster than a pendulum of {length:.4g} m "
        "does: its length, the clock or the scale of the angles is wrong, and so is e."
    ),
    "balls_slower": Rule(
        "Between impacts the balls swing {percent:.2g} % slower than a pendulum of {length:.4g} m "
        "does: its length, the clock or the scale of the angles is wrong, and so is e."
    ),
    "changed_restitution": Rule(
        "One coefficient of restitution does not describe these impacts: it is {before} before "
        "{time:.4g} s and {after} after it."
    ),
    # what is assumed of a table
    "only_angles": Rule("positions are in pixels without a scale, so only angles are kept"),
    "unit_from": Rule("{column} is in [{unit}], from {source}"),
    "rows_are_frames": Rule("the file has no times; each row is a frame"),
    "empty_row": Rule("1 row without numbers left out"),
    "empty_rows": Rule("{count} rows without numbers left out"),
    "times_from": Rule("times are counted from {time}"),
    "times_of_frames": Rule("times are those of frames at {rate:g} per second"),
    "divided_frames": Rule("times are frame numbers divided by {rate:g} per second"),
    "removed_jumps": Rule("jumps of a whole turn removed from {column}"),
    "shifted_turn": Rule("{column} is shifted by a whole turn"),
    "shifted_turns": Rule("{column} is shifted by {count} whole turns"),
    "seems_degrees": Rule(
        "{column} swings to and fro by {size:.3g} rad, which is more than half a turn: is it in "
        "degrees, and its unit wrong?"
    ),
    "stated_above": Rule(
        "{column} is above the pivot in most rows: is it counted from the x axis "
        "({@angle_from=right})?"
    ),
    "placed_above": Rule(
        "{column} is above the pivot in most rows: does y point down ({@y_axis=down})?"
    ),
    # why a table cannot be imported
    "own_table": Rule("it is a track table already", "use it as it is"),
    "one_table": Rule("leave it out: the file is one table"),
    "several_runs": Rule(
        "it holds {count} runs beside each other: {names}",
        "choose one with {@section}, as in '{first}'",
    ),
    "several_tracks": Rule(
        "it has {count} tracks: {names}",
        "name the columns of one or two with {@columns}, as in {target} = '{first}'",
    ),
    "frames_only": Rule("it has frame numbers and no time", "give {@frame_rate} in 1/s"),
    "needless_rate": Rule(
        "column {column} holds times, which need no frame rate", "leave out {@frame_rate}"
    ),
    "no_headings": Rule(
        "it has no names above its columns ({count})",
        "name them by position with {@columns}, as in time = '1 [s]'",
    ),
    "unclear_time": Rule(
        "it is not clear which column is {target}; it has {names}",
        "name it with {@columns}, as in {target} = '{path} [{unit}]'; if each row is a frame, give "
        "{@frame_rate} in 1/s",
    ),
    "unclear_angle": Rule(
        "it is not clear which column is {@angle_1}; it has {names}",
        "name it with {@columns}, as in {target} = '{path} [{unit}]'",
    ),
    "column_without_numbers": Rule(
        "column {column} holds no numbers",
        "save the file with the values of its formulas, or name another column",
    ),
    "rival_columns": Rule(
        "{count} columns may be {target}: {places}",
        "name one by its position with {@columns}, as in {target} = '{position}'",
    ),
    "which_time": Rule(
        "which column is the time?",
        "name it with {@columns}, as in time = 't [s]', or give {@frame_rate} if each row is a "
        "frame",
    ),
    "no_target": Rule("a track table has no column '{name}'"),
    "angle_or_rate": Rule("give {@angle_1} or {rate}, not both"),
    "split_frames": Rule(
        "rows cannot be counted as frames, since line {line} is no row",
        "add a column of frame numbers, or remove that line",
    ),
    "missing_time": Rule("the time is missing in line {line}", "complete or remove that line"),
    "falling_time": Rule(
        "must increase strictly, above {time:g} in line {line}",
        "sort the rows, remove repeats, or cut the file where a new run begins",
    ),
    "far_number": Rule(
        "line {line} of column {column} holds {number:g}, which is far from the other numbers",
        "leave the cell empty if the number is missing",
    ),
    "rate_needs_frames": Rule(
        "column {column} holds no frame numbers, which a frame rate needs",
        "name the column of frame numbers as {@time}, or leave out {@frame_rate}",
    ),
    "frames_need_rate": Rule(
        "column {column} holds frame numbers, not times", "give {@frame_rate} in 1/s"
    ),
    "mixed_positions": Rule(
        "{name} is in pixels, but {other} is not", "use one unit for positions"
    ),
    "no_unit": Rule(
        "the unit of column {column} is missing",
        "write it in brackets with {@columns}, as in {target} = '{path} [{unit}]'; it may be "
        "{units}",
    ),
    "misspelt_unit": Rule(
        "column {column} is in [{unit}], which may mean [{meant}]", "write [{meant}]"
    ),
    "foreign_unit": Rule(
        "column {column} is in [{unit}], which is not a unit of {target}", "it may be {units}"
    ),
    "two_coordinates": Rule("must be two numbers x, y"),
    "pivot_twice": Rule("give the pivot either as numbers or as columns, not both"),
    "half_place": Rule("{name} needs its other coordinate too"),
    "pivot_needed": Rule(
        "angles from positions need the pivot",
        "give its x and y as {@pivot}, or its columns {@pivot_x} and {@pivot_y}",
    ),
    "few_rates": Rule("{rate} needs at least 8 numbers at increasing times"),
    "few_turns_of_rate": Rule("an angle from {rate} needs a swing with at least 6 turning points"),
    # why a track table cannot be read
    "lacking_columns": Rule("it lacks these columns of a track table: {names}"),
    "no_row": Rule("a track table needs rows, but this one has none", "give one row or more"),
    "unit_of_column": Rule("the unit of column '{parameter}' must be [{unit}]"),
    "numbers_of_column": Rule("column '{parameter}' must hold numbers"),
    "whole_numbers_of_column": Rule("column '{parameter}' must hold whole numbers"),
    "infinite_numbers": Rule(
        "column '{parameter}' must not hold infinite numbers", "write NaN for unknown ones"
    ),
    "missing_in_row": Rule("must be known in every row, but is missing in row {row}"),
    "falling_row": Rule(
        "must increase strictly, above {last:g} in row {row}", "sort the rows and remove repeats"
    ),
    # why a video cannot be read; FFmpeg's own reasons are quoted in English
    "empty_video": Rule("it is empty", "choose another file"),
    "not_video": Rule("it cannot be read as a video (FFmpeg: '{fault}')"),
    "empty_container": Rule("it cannot be read as a video: it is empty"),
    "no_stream": Rule("it holds no video stream, only sound or data"),
    "frames_without_size": Rule("the size of its frames is unknown"),
    "no_decoded_frame": Rule("no frame could be decoded"),
    "decoding_fails": Rule("its frames cannot be decoded (FFmpeg: '{fault}')"),
    "missing_end": Rule("the file is cut off: its last {count} bytes are missing", "copy it again"),
    "missing_part": Rule(
        "the file is cut off: {count} frames are there, {seconds} of {declared} s", "copy it again"
    ),
    "damaged_video": Rule(
        "the file is damaged: frame {count} cannot be decoded (FFmpeg: '{fault}')",
        "copy it again, or use the part before that ({@end})",
    ),
    "part_before_damage": Rule(
        "the file is damaged: frame {count} cannot be decoded (FFmpeg: '{fault}'), so only the "
        "part before is used; copy the file again to have the rest"
    ),
    "interlaced": Rule(
        "its frames are interlaced: odd and even rows were filmed at different times",
        "make frames of them, e.g. with ffmpeg -i VIDEO -vf bwdif -crf 16 NEW.mp4",
    ),
    "no_time_stamp": Rule(
        "frame {number} has no time stamp",
        "declare the frame rate, e.g. with ffmpeg -framerate 30 -i VIDEO -c copy NEW.mp4",
    ),
    "other_size": Rule(
        "frame {number} differs in size from those before it: {width} x {height} pixels"
    ),
    "falling_stamp": Rule(
        "time stamps must increase, but frame {number} is at {time:.6g} s after {last:.6g} s",
        "write the frames again, e.g. with ffmpeg -i VIDEO -crf 16 NEW.mp4",
    ),
    "part_ends_first": Rule("must not lie after {@end}, which is {end:.6g} s"),
    "empty_part": Rule(
        "no sample lies between {@start} and {@end}: the table goes from {first:.6g} to {last:.6g} "
        "s"
    ),
    "no_frame_between": Rule("no frame lies between start ({start} s) and end ({end} s)"),
    "start_after_end": Rule("must lie before the end of the video at {time:.6g} s"),
    "beyond_limit": Rule(
        "{found}, at most {limit:.10g} {unit} are allowed",
        "cut the video or scale it down, or raise the limit of its {name}",
    ),
    "size_of_frames": Rule("frames of {width} x {height} pixels"),
    "memory_of_frames": Rule(
        "frames of {width} x {height} pixels take up to {memory:.2g} bytes of memory"
    ),
    "seconds_so_far": Rule("{seconds:.4g} s are there"),
    "frames_so_far": Rule("{count} frames are there"),
    "seconds_in_all": Rule("it is {seconds:.4g} s long"),
    "frames_in_all": Rule("it has {count} frames"),
    "too_few_frames": Rule("too few frames ({count}): tracking needs at least {least}"),
    # why a video cannot be tracked: what the user pointed at and gave
    "half_stick": Rule("is missing: a stick needs both of its ends and its length"),
    "short_stick": Rule(
        "the ends of a stick must be at least {least:g} pixels apart in the picture, but are "
        "{apart:.3g}",
        "point at both ends again, or use a longer stick",
    ),
    "outside_region": Rule(
        "the ball at {place} lies outside the region from {one} to {other}",
        "make the region larger",
    ),
    "pivot_on_ball": Rule("pivot and ball must be at least {least:g} pixels apart"),
    "near_balls": Rule(
        "two balls must be at least {least:g} pixels apart",
        "point at each of them, or at one only",
    ),
    "pivot_at_edge": Rule(
        "the pivot at {place} must lie at least {least} pixels inside the picture"
    ),
    "long_readout": Rule(
        "must let {rows} rows fit between two frames {pause:.3g} s apart",
        "give the time from one row to the next, not that of all rows",
    ),
    "unused_correction": Rule(
        "frame {frame} is corrected, but only frames {first} to {last} are used",
        "remove the correction, or use that frame too",
    ),
    "correction_of_none": Rule(
        "ball {ball} is corrected in frame {frame}, but there is only one",
        "remove the correction, or point at both balls",
    ),
    "bob_without_pivot": Rule(
        "a bob that is not a disc can only be followed about a pivot in the picture",
        "point at the pivot, or at a disc on the bob",
    ),
    "two_lengths": Rule(
        "the balls are {one} and {other} pixels from their pivots: one length cannot fit both",
        "leave out the length here, and give it in the fit of each ball",
    ),
    # what is seen where a ball was taken to be
    "small_disc": Rule(
        "no ball with a rim was found at {place}",
        "point at the middle of the ball, or give its radius and length",
    ),
    "like_surroundings": Rule(
        "what was taken for the ball looks like its surroundings",
        "point at the middle of the ball",
    ),
    "found_once": Rule(
        "no ball like the one at {place} was found in other frames",
        "point at the middle of the ball, and check radius and length if you gave them",
    ),
    "hidden_rim": Rule(
        "the rim of what is followed lies outside the picture or beside the other ball in all "
        "frames from which it is learned",
        "point at the middle of a ball that the picture shows as a whole",
    ),
    "plain_patch": Rule(
        "the patch around the middle of the bob looks like its surroundings",
        "point at the bob, or make the patch larger",
    ),
    "patch_found_once": Rule(
        "nothing like the patch at {place} was found in other frames",
        "point at the middle of the bob, or choose another patch",
    ),
    # what was followed
    "rarely_found": Rule(
        "what was taken for the ball, at {place} in frame {frame}, was found in only {percent} % "
        "of the samples ({clean} % are ok)",
        "point at the middle of the ball",
    ),
    "rarely_found_path": Rule(
        "what was taken for the ball, at {place} in frame {frame}, was found in only {percent} % "
        "of the samples, and no swing was seen: {doubt}",
        "point at the middle of the ball that swings, and at its pivot",
    ),
    "long_and_thin": Rule(
        "what moves is long and thin, and no ball stands out from it", "point at pivot and ball"
    ),
    "jumping_ball": Rule(
        "what was followed at {place} does not swing: it jumps about by {scatter} pixels",
        "point at the middle of the ball that swings",
    ),
    "other_pivot": Rule(
        "what was followed is {low} to {high} pixels from the pivot at {place}, so it does not "
        "swing about it",
        "point at the middle of the ball and at the pivot about which it swings, mark a pivot that "
        "moves so that the picture shows it, or declare one that is not in the picture 'outside'",
    ),
    "second_ball": Rule(
        "a second ball that looks the same meets this one at {time:.4g} s: from then on one may be "
        "taken for the other",
        "point at both ({@balls=2}), or use the part before that ({@end})",
    ),
    "upside_down": Rule(
        "the picture is upside down: the balls swing in it as if gravity pulled them upwards",
        "turn the video, e.g. with ffmpeg -i VIDEO -vf hflip,vflip -crf 16 NEW.mp4",
    ),
    # why there is no fit and no trial
    "moving_pivot": Rule(
        "the pivot moves by {size:.3g} mm either way: a decay needs a pivot at rest",
        "use fit_model, or set {@start} and {@end} to a part where it is at rest",
    ),
    "jumping_angle": Rule(
        "the angle jumps by {jump:.3g} rad at {time:.4g} s: the camera or the film changes there",
        "give {@end}, or {@start}, to use one part",
    ),
    "turned_angle": Rule(
        "the angle jumps by {turn} at {time:.4g} s, which no ball does between two samples",
        "take the turn off the angles from there on",
    ),
    "beyond_half_turn": Rule(
        "the angle reaches {reach:.3g} rad on one side, more than half a turn, which no free swing "
        "does: are the angles in degrees? If not, leave out what comes before the swing"
    ),
    "no_crossings": Rule(
        "no swing was found: the angle does not cross zero twice beyond its noise"
    ),
    "constant_angle": Rule("no free swing was found: the angle is the same in all samples"),
    "few_crossings": Rule(
        "no free swing was found: the angle passes its middle fewer than three times",
        "use a longer part; of turning points give those of both sides",
    ),
    "held_ball": Rule("no free swing was found after the release", "give start"),
    "few_clean": Rule("ball {ball} has {count} samples flagged ok, but a fit needs at least 8"),
    "few_turning_points": Rule(
        "an envelope needs at least 6 turning points", "use a longer part or method 'equation'"
    ),
    "large_radius": Rule("must be less than the length {length:.4g} m from the dynamics"),
    "few_samples": Rule(
        "{count} samples are too few to fit {names}",
        "use a longer part, of {least} samples or more",
    ),
    "lost_fit": Rule("the fit with {law} drag did not converge", "use another part of the record"),
    "follows_few": Rule(
        "the fit of {names} follows only {count} of {total} samples",
        "fit fewer parameters, or use another part",
    ),
    "left_range": Rule(
        "the fit of {names} left the range of its model",
        "fit fewer parameters, or use another part",
    ),
    "many_trials": Rule(
        "the fit of {names} did not converge in {count} trials",
        "fit fewer parameters, or use another part",
    ),
    "not_told_apart": Rule(
        "the samples do not tell {names} apart", "fit fewer parameters, or use another part"
    ),
    "does_not_depend": Rule(
        "the samples do not depend on {names}", "fit fewer parameters, or use another part"
    ),
    "no_column": Rule(
        "the {quantity} was not measured", "the track table needs a column '{column}'"
    ),
    "empty_column": Rule(
        "the {quantity} was not measured",
        "the column '{column}' of the track table holds no numbers",
    ),
    "few_pivots": Rule("the pivot is known in {count} samples, but a fit needs at least 16"),
    "fast_pivot": Rule(
        "the pivot's height changes by {noise:.3g} mm between samples {pause:.3g} s apart: it "
        "moves too fast for them",
        "film more frames a second",
    ),
    "few_passages": Rule(
        "the pivot passes its middle {count} times: a drive needs at least 3 periods"
    ),
    "sideways_pivot": Rule(
        "the pivot moves only sideways, by {size:.3g} mm either way: a drive is fitted to its "
        "height, which changes by {up:.3g} mm, its track scatters by {scatter:.3g} mm",
        "use fit_model, which follows the pivot's track, or MeasuredPivot",
    ),
    "constant_pivot": Rule("the pivot is at rest: its height is the same in all frames"),
    "resting_pivot": Rule(
        "the pivot is at rest: it moves by {up:.3g} mm either way, and its track scatters by "
        "{scatter:.3g} mm"
    ),
    "fast_stages": Rule("a drive faster than half the rate of the samples has no stages"),
    "no_shape": Rule("no drive of this shape describes the pivot's height"),
    "few_cycles": Rule(
        "the pivot moves through {count:.2g} cycles in this record: a drive needs at least 2",
        "use a longer record",
    ),
    "short_drive": Rule("the drive is too short for {count} stages"),
    "scale_of_motion": Rule("must be known: it is the scale of the motion"),
    "partly_known_pivot": Rule(
        "the pivot is not known for the whole motion: give {@start} and {@end}, or the drive"
    ),
    "two_pivots": Rule("the balls hang from separate pivots: their impacts cannot be fitted"),
    "own_pivots": Rule(
        "the balls of a {system} hang from one pivot, but those of this table from separate pivots",
        "use a Pendulum for each ball",
    ),
    "flights_length": Rule("needs length [m]: the flights are pendulum motion"),
    "end_of_drive": Rule(
        "must be at most {latest:.6g} s, where the samples of the drive end",
        "give less, or a drive with later samples",
    ),
    "few_ok": Rule("ball {ball} has fewer than {count} samples flagged ok"),
    "no_reversal": Rule("no impact was seen: the angle between the balls never reverses"),
    "no_impact": Rule(
        "no impact was seen well enough: {count} reversals of the angle are smooth, too slow or "
        "have too few samples",
        "use a faster camera",
    ),
    "no_angles": Rule("no pivot in the picture: no angles"),
    "unknown_length": Rule("is not in the table", "give it"),
    "broken_trial": Rule("{doubt}", "give {@start} and {@end} of a part without a break"),
    "angles_elsewhere": Rule(
        "ball {ball} moves about {angle:.4g} degrees, but a ball that hangs is at 0: its angles "
        "are counted from elsewhere, or are off by a turn",
        "import them with {@angle_from}, or take the turn off",
    ),
    "few_frames": Rule("ball {ball} was seen in {count} frames, but a trial needs at least 8"),
    "few_late_frames": Rule("the ball was seen in {count} frames of the last part"),
    # notes of a trial
    "note_step": Rule("frequency stepped at {time:.4g} s"),
    "note_amplitude": Rule("unusual drive amplitude: units?"),
    "note_frequency": Rule("unusual drive frequency: units?"),
    "note_unsteady": Rule("drive not steady"),
    "note_settling": Rule("not settled in the last part"),
    # warnings of tracking: of the film
    "moving_camera_corrected": Rule(
        "the camera moves by up to {pixels} pixels: corrected on the background"
    ),
    "moving_camera": Rule(
        "the camera moves: the background shifts by up to {pixels} pixels (at {time:.4g} s)",
        "film on a tripod for full accuracy",
    ),
    "moved_camera": Rule(
        "the camera moves: the background shifts by up to {pixels} pixels (at {time:.4g} s)",
        "film with the camera on a tripod, or use a part in which it rests ({@start}, {@end})",
    ),
    "carried_ball": Rule(
        "the camera moves: the background shifts by up to {pixels} pixels (at {time:.4g} s), and "
        "what was followed moves with it: by {extent} pixels only before the background",
        "point at the ball that swings, and film with the camera on a tripod",
    ),
    "repeated_frame": Rule(
        "1 frame repeats the previous picture: such frames are out of date and not measured{times}"
    ),
    "repeated_frames": Rule(
        "{count} frames repeat the previous picture: such frames are out of date and not "
        "measured{times}"
    ),
    "even_times": Rule(
        "; they do so regularly, as after a conversion to another frame rate: times are assumed to "
        "be even, not as in the file"
    ),
    "missing_frame": Rule(
        "1 frame is missing according to the time stamps, the gap is {gap:.3g} s"
    ),
    "missing_frames": Rule(
        "{count} frames are missing according to the time stamps, the longest gap is {gap:.3g} s"
    ),
    "cut_off": Rule(
        "{count} of the {total} frames that the file declares are missing: it is cut off"
    ),
    "not_decoded": Rule(
        "{count} of the {total} frames that the file declares could not be decoded"
    ),
    "unsure_pace": Rule(
        "the file says that {filmed:.4g} frames a second were filmed and {shown:.4g} are shown: if "
        "it is slow motion, declare one of {factor:.3g}"
    ),
    "changed_pace": Rule(
        "the clip changes its pace (slow motion {paces}{known}): track its parts separately, "
        "{parts}"
    ),
    "pace_from": Rule("{factor} from {begin} to {end} s"),
    "pace_known": Rule(", if its fastest part is at normal speed"),
    "pace_part": Rule("start {begin} and end {end} s with slow motion {factor}"),
    "too_slow": Rule("the swing is {factor} times too slow for its length and gravity: {advice}"),
    "too_fast": Rule("the swing is {factor} times too fast for its length and gravity: {advice}"),
    "declare_pace": Rule("declare a slow motion of {factor}, or correct the length"),
    "correct_length": Rule("correct the length"),
    "cut_clip": Rule(
        "the clip is not in one piece: {places}, so times there are not those of the swing",
        "track its pieces separately ({@start}, {@end})",
    ),
    "cut_at": Rule("it is cut at {time:.4g} s"),
    "still_picture": Rule("the picture stands still from {begin:.4g} to {end:.4g} s"),
    "more_places": Rule("{count} more"),
    "late_stamps": Rule(
        "the time stamps are off by about {late:.2g} ms: the deviations of fast balls include that"
    ),
    "distorted_path": Rule(
        "the ball's path is distorted (lens, perspective or rolling shutter), or the pivot is some "
        "pixels off: angles may be off by {off:.2g} mrad; declare the lens ({@lens_k1}) or the "
        "shutter ({@row_time}), or point at the middle of the pivot"
    ),
    "oblique_camera": Rule(
        "the camera looks at the swing at an angle of {angle} degrees: angles are corrected for "
        "the oval seen; film along the pivot's axis for full accuracy"
    ),
    # of the pivot, the scale and gravity
    "proposed": Rule("found in the video: {options}"),
    "proposed_without_pivot": Rule(
        "found in the video: {options}; no pivot was found in the picture"
    ),
    "declared_pivot": Rule(
        "the pivot declared at {declared} is not the centre of the ball's arc, {centre} give or "
        "take {away} pixels, which is used instead"
    ),
    "pivot_of_arc": Rule(
        "the pivot is not in the picture: it is assumed to be at rest at {place}, the centre of "
        "the ball's arc; all angles share an error of {percent:.2g} %"
    ),
    "pivot_and_scale_of_arc": Rule(
        "the pivot is not in the picture: it is assumed to be at rest at {place}, the centre of "
        "the ball's arc; all angles, and the scale, share an error of {percent:.2g} %"
    ),
    "other_centre": Rule(
        "the ball moves as well on a circle about {place}, {pixels} pixels from where the pivot "
        "was taken to be: if the pivot is there, point at it; the deviations contain both"
    ),
    "unknown_gravity": Rule(
        "the direction of gravity cannot be found (the clip shows neither the axis of a drive nor "
        "a free swing about a pivot at rest): angles are measured from straight down in the "
        "picture, ± {angle} degrees"
    ),
    "no_scale": Rule(
        "the length is unknown, so positions are in pixels only; to set the scale, give the "
        "length, a stick, or the radius of a ball"
    ),
    "other_radius_by_length": Rule(
        "the radius of a ball is {measured} mm by the scale of the length, declared were "
        "{declared} mm: is the length from pivot to ball centre right?"
    ),
    "other_radius_by_stick": Rule(
        "the radius of a ball is {measured} mm by the scale of the stick, declared were "
        "{declared} mm: is the stick right?"
    ),
    "other_radius_by_radius": Rule(
        "the radius of a ball is {measured} mm by the scale of the radius, declared were "
        "{declared} mm: is the radius right?"
    ),
    "other_stick_by_length": Rule(
        "the stick is {measured} mm by the scale of the length, declared were "
        "{declared} mm: is the length from pivot to ball centre right?"
    ),
    "unknown_geometry": Rule(
        "{doubt}: the geometry is unknown, so there are no angles and the ball's positions are in "
        "pixels; its period is in the table's attributes"
    ),
    "rarely_seen": Rule("the ball was seen too rarely to locate its pivot"),
    "straight_path": Rule(
        "the path is too straight to locate the pivot: it is more than about {pixels} pixels from "
        "the ball"
    ),
    "outside_pivot_moves": Rule(
        "the pivot seems to move outside the picture, by {pixels} pixels at {rate:.2g} Hz, or at a "
        "frequency that looks the same in {frames:.3g} frames a second"
    ),
    "unclear_drive": Rule(
        "the paths of the balls do not tell where the pivot is: as if it were driven at {one}, or "
        "at {other}",
        "point at the pivot, or at both if each ball has its own",
    ),
    "unseen_drive": Rule(
        "nothing in the picture shows how the pivot at {place} moves: the paths of the balls tell "
        "that it does, up and down by {pixels} pixels at {rate:.3g} Hz, or at a frequency that "
        "looks the same in {frames:.3g} frames a second"
    ),
    "no_circle": Rule(
        "the path is not a circle about a pivot at rest: places are typically {pixels} pixels off "
        "the best one"
    ),
    "period_changes": Rule(
        "the period changes from {before:.5g} to {after:.5g} s between the halves of the clip, as "
        "with the amplitude, with the length, or where films are joined"
    ),
    "no_period": Rule("no period: fewer than three swings were seen"),
    "off_centre": Rule(
        "the ball does not move on a circle about the pivot (centre off by {offset} pixels, "
        "residual {residual} pixels): lens, perspective or rolling shutter; the pivot stays where "
        "it was taken to be"
    ),
    "swaying_pivot": Rule(
        "the ball's distance from the pivot varies by {varies} pixels, more than its scatter: the "
        "pivot may sway by {sway:.2g} pixels unseen, which the deviations contain"
    ),
    # of the ball
    "hard_to_follow": Rule("the ball was measured in only {percent} % of the samples: {advice}"),
    "wrong_pace": Rule(
        "check the slow motion of {factor:g}, as a wrong one makes the ball hard to follow"
    ),
    "turning_pattern": Rule(
        "the ball has a pattern that turns with it: where the pattern resembles the background, "
        "angles are off by {off:.2g} mrad or more"
    ),
    "few_seen": Rule(
        "only {percent} % of the samples are ok ({flags}): {reason}; look at the overlay"
    ),
    "share_occluded": Rule("{percent} % occluded"),
    "share_predicted": Rule("{percent} % predicted"),
    "share_lost": Rule("{percent} % lost"),
    "unseen_stretch": Rule(
        "most of the others lie between {begin:.3g} and {end:.3g} s, where the ball is hidden, is "
        "held, or leaves its circle about the pivot"
    ),
    "leaping": Rule(
        "what was followed moves by {leap} of its diameters between frames, so it may not be the "
        "ball"
    ),
    "hidden_ball": Rule("there the ball is partly hidden, or what was followed is not the ball"),
    "nothing_near": Rule("nothing else like the ball is near where it is expected"),
    "nothing_on_circle": Rule(
        "elsewhere nothing like the ball lies on its circle about the pivot, so the pivot is "
        "wrong, the camera looks at an angle, or the ball is hard to see"
    ),
    "ball_not_in_frame": Rule(
        "1 ball was found in {seen} of {count} frames, but not in frame {frame}",
        "point at pivot and ball, or look in another frame ({@click_frame})",
    ),
    "balls_not_in_frame": Rule(
        "2 balls were found in {seen} of {count} frames, but not in frame {frame}",
        "point at pivot and balls, or look in another frame ({@click_frame})",
    ),
    "unlike_pixels": Rule(
        "{percent} % of the measured samples are given up as lost: there the pixels under it do "
        "not change as those under a ball",
        "look at these frames in the overlay",
    ),
    "part_of_larger": Rule(
        "the disc of {radius} pixels radius that was followed is a part of something larger that "
        "moves with it",
        "give the ball's radius and length",
    ),
    "not_where_pointed": Rule(
        "the ball is not seen where it was taken to be, at {time:.4g} s: the nearest frame that "
        "shows one is {count} frames away, at {near:.4g} s",
        "point at the middle of the ball, or in a frame that shows it ({@click_frame})",
    ),
    "other_ball": Rule(
        "the ball that was followed is at {place} with a radius of {radius} pixels, {pixels} "
        "pixels from where it was taken to be",
        "point at the middle of the ball",
    ),
    "other_radius": Rule(
        "what was followed has a radius of {radius} pixels, the declared radius is {declared} "
        "pixels by the scale",
        "check radius and length (from pivot to ball centre) and point at the middle of the ball; "
        "without a radius it is measured",
    ),
    "resting_ball": Rule(
        "what was followed at {place} moves by {extent} pixels in the whole clip: it rests",
        "point at the ball that swings, and not at its pivot instead",
    ),
    "small_motion": Rule(
        "what was followed moves by {extent} pixels, too little for a disc of {radius} pixels "
        "radius to be told from the wall",
        _BALL,
    ),
    "busy_background": Rule(
        "what was followed cannot be told from the background, which changes as well: of the "
        "pixels under it (radius {radius} pixels) {under} % change when it comes, of those around "
        "it {beside} %, elsewhere {elsewhere} %",
        "film the ball in front of a background at rest",
    ),
    "no_ball": Rule(
        "what was followed is no ball that moves: of the pixels under it (radius {radius} pixels) "
        "{under} % change when it comes, of those around it {beside} %, elsewhere {elsewhere} %",
        _BALL,
    ),
}

broken = partial(broken_rule, table=RULES)


def said(rule: str, /, **values: Any) -> Sentence:
    """The sentence of a rule."""
    return sentence(rule, RULES, **values)


def listed(texts: Sequence[str]) -> str:
    """Return texts as a list in words."""
    *others, last = texts
    return said("and_last", others=", ".join(others), last=last) if others else last


def place_text(*places: Iterable[float]) -> str:
    """Return columns and rows of places in a picture [pixels] as a text."""
    return listed([f"({u:.0f}, {v:.0f})" for u, v in places])
