# Choices between two stimuli, as the rooms of preferences and scales take them.

# One row per answer: its pair (i before j in alphabetical order), whether i was chosen (NA: not sure),
# whether i was shown first, who answered, and in which set of pairs.
choices_of <- function(responses) {
  a <- as.character(responses$stimulus_a)
  b <- as.character(responses$stimulus_b)
  i <- pmin(a, b)
  data.frame(
    i = i, j = pmax(a, b), won = as.numeric(as.character(responses$selected) == i),
    first = (responses$first == "a") == (a == i), observer = as.character(responses$subject),
    set = paste(responses$study, responses$subject, responses$session, responses$repetition))
}

items_of <- function(choices) sort(unique(c(choices$i, choices$j)))

# Choices of those sets in which every pair was decided, or all if there is no such set.
complete_of <- function(choices) {
  pairs <- nrow(unique(choices[c("i", "j")]))
  decided <- tapply(!is.na(choices$won), choices$set, sum)
  complete <- choices[choices$set %in% names(decided)[decided == pairs], ]
  if (nrow(complete) > 0) complete else choices[!is.na(choices$won), ]
}

# How often the row was chosen over the column.
wins_of <- function(choices, items = items_of(choices)) {
  winner <- ifelse(choices$won == 1, choices$i, choices$j)
  loser <- ifelse(choices$won == 1, choices$j, choices$i)
  unclass(table(factor(winner, items), factor(loser, items)))
}

# One row per pair that was compared: wins of i and of j, a "not sure" as half a win of both.
pairs_of <- function(choices) {
  choices$won <- ifelse(is.na(choices$won), 0.5, choices$won)
  aggregate(cbind(wins = won, losses = 1 - won) ~ i + j, choices, sum)
}

# +1 for the first and −1 for the second of each pair.
differences_of <- function(pairs, items) {
  outer(pairs$i, items, "==") - outer(pairs$j, items, "==")
}
