# Scales: Bradley and Terry's model, Thurstone's Case V and Davidson's ties, against the fits of R.

# Coefficients with one item at zero, as values with sum zero and their standard errors.
centred <- function(coefficients, covariance, items) {
  at <- match(names(coefficients), items)
  beta <- replace(numeric(length(items)), at, coefficients)
  v <- matrix(0, length(items), length(items))
  v[at, at] <- covariance
  centre <- diag(length(items)) - 1 / length(items)
  list(value = drop(centre %*% beta), v = centre %*% v %*% centre)
}

# BradleyTerry2::BTm to all its digits; `br` for bias reduction.
fit_btm <- function(pairs, link, br = FALSE) {
  items <- sort(unique(c(pairs$i, pairs$j)))
  player <- function(ids) data.frame(stimulus = factor(ids, items))
  fit <- function(...) {
    BradleyTerry2::BTm(cbind(pairs$wins, pairs$losses), player(pairs$i), player(pairs$j), ~ stimulus,
                       id = "stimulus", family = binomial(link), ...)
  }
  model <- if (br) fit(br = TRUE, br.epsilon = 1e-12, br.maxit = 1000) else fit(control = exact_glm)
  names(model$coefficients) <- sub("^stimulus", "", names(model$coefficients))
  model
}

compare_scale <- function(study, what, ours, choices, link, by = "BradleyTerry2::BTm") {
  pairs <- pairs_of(choices)
  items <- ours$scale$items
  separated <- ours$scale$estimation == "BiasReduced"
  model <- fit_btm(pairs, link, separated)
  if (separated) by <- paste0(by, ", br = TRUE")
  r <- centred(coef(model), vcov(model), items)
  se <- sqrt(diag(r$v))
  compare(study, paste(what, "values"), ours$scale$values, r$value, by, 1e-6, size = max(abs(r$value)))
  compare(study, paste(what, "SE"), ours$scale$se, se, by, 1e-6)
  compare(study, paste(what, "Wald intervals"), unlist(ours$wald_95),
          rbind(r$value + qnorm(0.025) * se, r$value + qnorm(0.975) * se), by, 1e-6, size = max(abs(r$value)))
  i <- match(field(ours$differences, "item"), items)
  j <- match(field(ours$differences, "over"), items)
  z <- (r$value[i] - r$value[j]) / sqrt(diag(r$v)[i] + diag(r$v)[j] - 2 * r$v[cbind(i, j)])
  compare(study, paste(what, "z of differences"), field(ours$differences, "z"), z, by, 1e-6,
          size = pmax(1, abs(z)))
  p <- p.adjust(2 * pnorm(-abs(z)), "holm")
  compare(study, paste(what, "p of differences, Holm"), field(ours$differences, "p_holm"), p,
          "stats::p.adjust", 1e-5)
  if (separated) return()
  fit <- ours$goodness_of_fit
  null <- glm(cbind(wins, losses) ~ 0, binomial(link), pairs)
  compare(study, paste(what, "deviance, df, p"), c(fit$deviance, fit$df, fit$p),
          c(deviance(model), df.residual(model), pchisq(deviance(model), df.residual(model), lower.tail = FALSE)),
          by, 1e-6)
  pearson <- sum(residuals(model, "pearson")^2)
  compare(study, paste(what, "Pearson's χ² and its p"), c(fit$pearson, fit$p_pearson),
          c(pearson, pchisq(pearson, df.residual(model), lower.tail = FALSE)), by, 1e-6)
  lr <- deviance(null) - deviance(model)
  compare(study, paste(what, "equal worths, χ² and p"), c(fit$equal_worth$chi2, fit$equal_worth$p),
          c(lr, pchisq(lr, length(items) - 1, lower.tail = FALSE)), paste(by, "stats::glm", sep = ", "), 1e-6)
  if (all(pairs$wins == round(pairs$wins))) {
    compare(study, paste(what, "log-likelihood"), fit$log_likelihood, as.numeric(logLik(model)), by, 1e-6)
  }
}

# The value of each stimulus against the mean of all, held at a number: where the deviance has risen by
# the 95 % quantile of χ² with one degree of freedom.
compare_profiles <- function(study, what, ours, choices, link) {
  pairs <- pairs_of(choices)
  items <- ours$scale$items
  x <- differences_of(pairs, items)
  t <- length(items)
  deviance_at <- function(k, value) {
    held <- replace(rep(-value / (t - 1), t), k, value)
    z <- x[, -k] %*% contr.sum(t - 1)
    glm(cbind(wins, losses) ~ 0 + z + offset(x %*% held), binomial(link), pairs, control = exact_glm)$deviance
  }
  bounds <- vapply(seq_len(t), function(k) {
    estimate <- ours$scale$values[k]
    rise <- function(value) deviance_at(k, value) - deviance_at(k, estimate) - qchisq(0.95, 1)
    step <- 4 * ours$scale$se[k]
    c(uniroot(rise, c(estimate - step, estimate), tol = 1e-9)$root,
      uniroot(rise, c(estimate, estimate + step), tol = 1e-9)$root)
  }, c(0, 0))
  compare(study, paste(what, "profile intervals"), unlist(ours$profile_95), bounds, "stats::glm, stats::uniroot",
          1e-6, size = max(abs(bounds)))
}

# The same choices as the object of psychotools: one row per set of pairs.
paircomp_of <- function(choices) {
  items <- items_of(choices)
  t <- length(items)
  order <- which(upper.tri(diag(t)), arr.ind = TRUE)
  sets <- split(choices, choices$set)
  data <- t(vapply(sets, function(set) {
    at <- match(paste(items[order[, 1]], items[order[, 2]]), paste(set$i, set$j))
    ifelse(is.na(set$won[at]), 0, 2 * set$won[at] - 1)
  }, numeric(nrow(order))))
  psychotools::paircomp(data, labels = items)
}

compare_btmodel <- function(study, ours, choices) {
  model <- psychotools::btmodel(paircomp_of(choices), undecided = FALSE, epsilon = 1e-14, maxit = 100)
  r <- centred(coef(model), vcov(model), ours$scale$items)
  compare(study, "Bradley–Terry: values", ours$scale$values, r$value, "psychotools::btmodel", 1e-6,
          size = max(abs(r$value)))
  compare(study, "Bradley–Terry: SE", ours$scale$se, sqrt(diag(r$v)), "psychotools::btmodel", 1e-6)
}

compare_davidson <- function(study, ours, choices) {
  model <- psychotools::btmodel(paircomp_of(choices), undecided = TRUE, epsilon = 1e-14, maxit = 100)
  beta <- coef(model)
  k <- length(beta)
  r <- centred(beta[-k], vcov(model)[-k, -k], ours$scale$items)
  compare(study, "Davidson: values", ours$scale$values, r$value, "psychotools::btmodel", 1e-6,
          size = max(abs(r$value)))
  compare(study, "Davidson: SE", ours$scale$se, sqrt(diag(r$v)), "psychotools::btmodel", 1e-6)
  compare(study, "Davidson: ln ν and its SE", c(ours$ln_nu$value, ours$ln_nu$se),
          c(beta[k], sqrt(vcov(model)[k, k])), "psychotools::btmodel", 1e-6)
}
