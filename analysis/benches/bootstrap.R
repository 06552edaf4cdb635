# The bootstrap of bootstrap.rs in R: answers (observer, i, j, i_chosen) are resampled by observer, and the
# Bradley-Terry model is fitted by maximum likelihood. Prints seconds per replicate, once for BTm of the
# package BradleyTerry2 and once for base R's glm.fit, the least that R can do.
answers <- read.csv(commandArgs(trailingOnly = TRUE)[1])
observers <- unique(answers$observer)
pairs <- unique(answers[c("i", "j")])
chosen <- t(sapply(observers, function(o) answers$i_chosen[answers$observer == o]))
items <- sort(unique(c(pairs$i, pairs$j)))
design <- outer(pairs$i, items, "==") - outer(pairs$j, items, "==")
replicate_counts <- function() {
  wins <- colSums(chosen[sample(length(observers), replace = TRUE), ])
  cbind(wins, length(observers) - wins)
}
per_replicate <- function(name, replicates, fit) {
  set.seed(1)
  seconds <- system.time(for (k in seq_len(replicates)) fit(replicate_counts()))[["elapsed"]]
  cat(name, "\t", seconds / replicates, "\n", sep = "")
}
if (requireNamespace("BradleyTerry2", quietly = TRUE)) {
  first <- factor(pairs$i, levels = items)
  second <- factor(pairs$j, levels = items)
  per_replicate(paste("BTm, BradleyTerry2", packageVersion("BradleyTerry2")), 200,
                function(counts) BradleyTerry2::BTm(counts, first, second))
}
per_replicate(paste("glm.fit, R", getRversion()), 500, function(counts) {
  glm.fit(design[, -1], counts, family = binomial(), intercept = FALSE)
})
