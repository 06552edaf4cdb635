# Matching and same/different: accuracy, tables, κ, d′, response times.

compare_accuracy <- function(study, what, ours, right, n) {
  study <- paste0(study, ", ", what)
  test <- function(f) mapply(f, right, n)
  ends <- function(name) unlist(lapply(ours, `[[`, name))
  compare(study, "share in percent", field(ours, "percent"), 100 * right / n, "arithmetic", 1e-10)
  compare(study, "share: Wilson's interval", ends("wilson_95"),
          test(function(k, n) prop.test(k, n, correct = FALSE)$conf.int), "stats::prop.test", 1e-10, size = 1)
  compare(study, "share: Clopper and Pearson's interval", ends("clopper_pearson_95"),
          test(function(k, n) binom.test(k, n)$conf.int), "stats::binom.test", 1e-10, size = 1)
  # Unequal numbers of identical and different pairs have no test against one half.
  if (anyNA(field(ours, "p_above_chance"))) return()
  compare(study, "share: p above chance", field(ours, "p_above_chance"),
          test(function(k, n) binom.test(k, n, 0.5, "greater")$p.value), "stats::binom.test", 1e-10)
}

# All answers, with an interval and a test that allow for observers who differ.
compare_observers <- function(study, ours, right, observer) {
  compare_accuracy(study, "all answers", list(ours$pooled), sum(right), length(right))
  k <- tapply(right, observer, sum)
  n <- tapply(right, observer, length)
  p <- mean(right)
  g <- length(k)
  se <- sqrt(g / (g - 1) * sum((k - n * p)^2)) / sum(n) / (p * (1 - p))
  ends <- plogis(qlogis(p) + qt(c(0.025, 0.975), g - 1) * se)
  compare(study, "accuracy, interval by clusters", ours$robust_95, ends, "definition, stats::qt", 1e-9)
  differ <- chisq.test(table(observer, right), correct = FALSE)
  compare(study, "observers differ, χ² and p", c(ours$heterogeneity$chi2, ours$heterogeneity$p),
          c(differ$statistic, differ$p.value), "stats::chisq.test", 1e-10)
}

# A table of two rows and two columns.
compare_confusion <- function(study, ours, table) {
  n <- sum(table)
  compare(study, "table, counts", unlist(ours$counts), t(table), "base::table", 0)
  test <- chisq.test(table, correct = FALSE)
  compare(study, "table, χ², p, Cramér's V",
          unlist(ours$association[c("chi2", "p", "cramers_v")]),
          c(test$statistic, test$p.value, sqrt(test$statistic / n)), "stats::chisq.test", 1e-10)
  p <- table / n
  row <- rowSums(p)
  column <- colSums(p)
  expected <- sum(row * column)
  kappa <- (sum(diag(p)) - expected) / (1 - expected)
  # Fleiss, Cohen and Everitt (1969), written out for the diagonal and the rest.
  a <- sum(diag(p) * (1 - (row + column) * (1 - kappa))^2)
  b <- (1 - kappa)^2 * sum((p * outer(column, row, "+")^2)[row(p) != col(p)])
  se <- sqrt(a + b - (kappa - expected * (1 - kappa))^2) / ((1 - expected) * sqrt(n))
  compare(study, "κ and its SE", c(ours$kappa$kappa, ours$kappa$se), c(kappa, se), "definition", 1e-10)
  compare(study, "mutual information, bits", ours$mutual_information_bits,
          sum(ifelse(p > 0, p * log2(p / outer(row, column)), 0)), "definition", 1e-10)
}

# d′ and its likelihood interval from hits and false alarms; `of_shares` is R's d′, `shares` gives hits
# and false alarms for d′ and a criterion from `criteria`.
compare_d_prime <- function(study, what, ours, table, of_shares, by, shares, criteria) {
  estimate <- ours$estimate
  yes <- c(table[2, 2], table[1, 2])
  n <- c(sum(table[2, ]), sum(table[1, ]))
  compare(study, paste(what, "d′"), estimate$d_prime, of_shares(yes[1] / n[1], yes[2] / n[2]), by, 1e-4)
  loss <- function(p) -2 * sum(dbinom(yes, n, p, log = TRUE))
  profile <- function(d) {
    optimize(function(criterion) loss(shares(d, criterion)), criteria, tol = 1e-10)$objective
  }
  rise <- function(d) profile(d) - loss(yes / n) - qchisq(0.95, 1)
  ends <- c(if (rise(0) < 0) 0 else uniroot(rise, c(0, estimate$d_prime), tol = 1e-9)$root,
            uniroot(rise, c(estimate$d_prime, 9), tol = 1e-9)$root)
  compare(study, paste(what, "d′, likelihood interval"), estimate$interval_95, ends,
          "stats::optimize, stats::uniroot", 1e-6, size = max(ends))
  # The delta method with derivatives by differences.
  d <- estimate$d_prime
  k <- estimate$criterion
  step <- 1e-5
  by_d <- (shares(d + step, k) - shares(d - step, k)) / (2 * step)
  by_k <- (shares(d, k + step) - shares(d, k - step)) / (2 * step)
  h <- yes / n
  back <- solve(cbind(by_d, by_k))
  compare(study, paste(what, "d′, SE"), estimate$se, sqrt(sum(back[1, ]^2 * h * (1 - h) / n)), "delta method", 1e-6)
}

differencing <- function(d, k) {
  c(pnorm((d - k) / sqrt(2)) + pnorm((-d - k) / sqrt(2)), 2 * pnorm(-k / sqrt(2)))
}

by_abx <- function(method) function(hits, false_alarms) {
  psyphy::dprime.ABX(Hits = hits, FA = false_alarms, method = method)
}

abx_shares <- function(of) function(d, criterion) {
  right <- pnorm(d / sqrt(2)) * pnorm(d / of) + pnorm(-d / sqrt(2)) * pnorm(-d / of)
  pnorm(c(1, -1) * qnorm(right) - criterion)
}

# Medians with R's default quantiles, the order statistics around them, and Wilcoxon's test of the
# observers' medians.
compare_times <- function(study, ours, conditions, seconds, observer, comparisons) {
  of <- function(rows) seconds[rows]
  times <- lapply(ours$response_times, `[[`, "times")
  compare(study, "response times, quartiles",
          unlist(lapply(times, function(one) unlist(one$quartiles[c("first", "median", "third")]))),
          unlist(lapply(conditions, function(rows) quantile(of(rows), c(0.25, 0.5, 0.75)))),
          "stats::quantile", 1e-10)
  compare(study, "response times, interval of the median",
          unlist(lapply(times, function(one) unlist(one$median_interval[c("low", "high")]))),
          unlist(lapply(conditions, function(rows) {
            n <- length(of(rows))
            sort(of(rows))[c(qbinom(0.025, n, 0.5), n + 1 - qbinom(0.025, n, 0.5))]
          })), "stats::qbinom", 1e-10)
  compare(study, "response times, geometric mean", field(times, "geometric_mean"),
          vapply(conditions, function(rows) exp(mean(log(of(rows)))), 0), "base::mean", 1e-10)
  p <- vapply(comparisons, function(two) {
    medians <- lapply(two, function(rows) tapply(seconds[rows], observer[rows], median))
    both <- intersect(names(medians[[1]]), names(medians[[2]]))
    wilcox.test(medians[[1]][both], medians[[2]][both], paired = TRUE)$p.value
  }, 0)
  compare(study, "response times compared, p", field(ours$comparisons, "test", "p"), p, "stats::wilcox.test", 1e-9)
}

# Reference and other stimulus of each trial, by the levels in which the stimuli of the study differ.
stimuli_of <- function(responses) {
  a <- as.character(responses$stimulus_a)
  b <- as.character(responses$stimulus_b)
  reference <- as.character(responses$reference)
  parts <- do.call(rbind, strsplit(c(reference, ifelse(reference == a, b, a)), "-", fixed = TRUE))
  differ <- apply(parts, 2, function(level) length(unique(level)) > 1)
  names <- apply(parts[, differ, drop = FALSE], 1, paste, collapse = "-")
  n <- nrow(responses)
  list(reference = names[seq_len(n)], other = names[n + seq_len(n)], a_is_reference = reference == a)
}

compare_matching <- function(study, ours, responses) {
  ours <- ours$matching
  stimuli <- stimuli_of(responses)
  reference <- stimuli$reference
  foil <- stimuli$other
  right <- as.character(responses$selected) == as.character(responses$reference)
  observer <- as.character(responses$subject)
  compare_observers(study, ours$accuracy, right, observer)
  sum_of <- function(rows) c(sum(right[rows]), sum(rows))
  cells <- vapply(ours$cells, function(one) sum_of(reference == one$reference & foil == one$foil), c(0, 0))
  compare_accuracy(study, "cells", ours$cells, cells[1, ], cells[2, ])
  pairs <- vapply(ours$pairs, function(one) sum_of(reference %in% one$levels & foil %in% one$levels), c(0, 0))
  compare_accuracy(study, "pairs", lapply(ours$pairs, `[[`, "accuracy"), pairs[1, ], pairs[2, ])
  p <- mapply(function(k, n) binom.test(k, n, 0.5, "greater")$p.value, pairs[1, ], pairs[2, ])
  compare(study, "pairs: p, Holm", field(ours$pairs, "p_holm"), p.adjust(p, "holm"), "stats::p.adjust", 1e-10)
  # dprime.ABX finds its root to four digits, and knows no share below ½.
  share <- pairs[1, ] / pairs[2, ]
  above <- share > 0.5 & share < 1
  for (method in c("diff", "IO")) {
    name <- if (method == "diff") "d_prime" else "d_prime_independent"
    r <- vapply(share[above], function(share) psyphy::dprime.ABX(Pc.unb = share, method = method), 0)
    compare(study, paste0("pairs: d′ of ABX, ", method), field(ours$pairs[above], name, "estimate", "d_prime"), r,
            "psyphy::dprime.ABX", 1e-4, size = 1)
  }
  first <- (responses$first == "a") == stimuli$a_is_reference
  chose_first <- first == right
  compare_confusion(study, ours$sides, table(!first, !chose_first))
  # "The first" is a hit where the reference was the first.
  hits <- table(first, chose_first)
  compare_d_prime(study, "ABX, differencing:", ours$d_prime, hits, by_abx("diff"), "psyphy::dprime.ABX",
                  abx_shares(sqrt(6)), c(-12, 12))
  compare_d_prime(study, "ABX, independent:", ours$d_prime_independent, hits, by_abx("IO"), "psyphy::dprime.ABX",
                  abx_shares(2), c(-12, 12))
  of <- lapply(ours$levels, function(level) reference == level)
  compare_times(study, ours, c(list(right | !right, right, !right), of), responses$response_time_s, observer,
                c(list(list(right, !right)), lapply(of, function(rows) list(!rows, rows))))
}

compare_same_different <- function(study, ours, responses) {
  ours <- ours$same_different
  stimuli <- stimuli_of(responses)
  different <- stimuli$other != stimuli$reference
  said <- as.character(responses$answer) == "different"
  compare_observers(study, ours$accuracy, different == said, as.character(responses$subject))
  table <- table(different, said)
  compare_confusion(study, ours$answers, table)
  by_sd <- function(method) function(hits, false_alarms) {
    psyphy::dprime.SD(H = hits, FA = false_alarms, method = method)
  }
  compare_d_prime(study, "same/different, differencing:", ours$d_prime, table, by_sd("diff"), "psyphy::dprime.SD",
                  differencing, c(0, 20))
  independent <- function(d, criterion) {
    pnorm(c(1, -1) * qnorm(pnorm(d / 2)^2 + pnorm(-d / 2)^2) - criterion)
  }
  compare_d_prime(study, "same/different, independent:", ours$d_prime_independent, table, by_sd("IO"),
                  "psyphy::dprime.SD", independent, c(-12, 12))
  counts <- vapply(ours$candidates, function(one) {
    signal <- stimuli$other == one$candidate & stimuli$reference == one$reference
    noise <- !different & stimuli$reference == one$reference
    c(sum(said & signal), sum(signal), sum(said & noise), sum(noise))
  }, numeric(4))
  compare(study, "candidates: hits and false alarms", unlist(lapply(ours$candidates, `[[`, "counts")), counts,
          "base::sum", 0)
  p <- apply(counts, 2, function(n) {
    fisher.test(matrix(c(n[1], n[2] - n[1], n[3], n[4] - n[3]), 2), alternative = "greater")$p.value
  })
  compare(study, "candidates: p", field(ours$candidates, "p"), p, "stats::fisher.test", 1e-9)
  compare(study, "candidates: p, Holm", field(ours$candidates, "p_holm"), p.adjust(p, "holm"), "stats::p.adjust",
          1e-9)
  for (method in c("diff", "IO")) {
    name <- if (method == "diff") "d_prime" else "d_prime_independent"
    inside <- counts[1, ] < counts[2, ] & counts[1, ] / counts[2, ] > counts[3, ] / counts[4, ]
    r <- apply(counts[, inside], 2, function(n) by_sd(method)(n[1] / n[2], n[3] / n[4]))
    compare(study, paste0("candidates: d′ of same/different, ", method),
            field(ours$candidates[inside], name, "estimate", "d_prime"), r, "psyphy::dprime.SD", 1e-4, size = 1)
  }
}
