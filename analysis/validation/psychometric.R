# Psychometric functions with a fixed guess rate, against glm with the links of psyphy.

compare_psychometric <- function(study, shape, ours, table, alternatives) {
  if (shape == "weibull") table$level <- log(table$level)
  name <- switch(shape, logistic = "logit", probit = "probit", weibull = "cloglog")
  link <- if (alternatives == 1) name
          else getExportedValue("psyphy", paste0("mafc.", name))(alternatives)
  by <- if (alternatives == 1) "stats::glm" else "glm, psyphy::mafc.…"
  study <- paste(study, shape, sep = ", ")
  model <- glm(cbind(chosen, trials - chosen) ~ level, binomial(link), table, control = exact_glm)
  fit <- ours$fit
  both <- list(fit$intercept, fit$slope)
  compare(study, "psychometric function: coefficients", field(both, "estimate"), coef(model), by, 1e-5)
  compare(study, "psychometric function: SE", field(both, "se"), summary(model)$coefficients[, 2], by, 1e-5)
  compare(study, "psychometric function: deviance, log-likelihood, AIC", c(fit$deviance, fit$log_likelihood, fit$aic),
          c(deviance(model), logLik(model), AIC(model)), by, 1e-5)
  guess <- if (alternatives == 1) 0 else 1 / alternatives
  share <- (ours$threshold$chance - guess) / (1 - guess)
  eta <- switch(shape, logistic = qlogis(share), probit = qnorm(share), weibull = log(-log(1 - share)))
  x <- (eta - coef(model)[[1]]) / coef(model)[[2]]
  gradient <- c(-1, -x) / coef(model)[[2]]
  se <- sqrt(drop(gradient %*% vcov(model) %*% gradient))
  level <- if (shape == "weibull") exp else identity
  compare(study, "psychometric function: threshold and its SE", c(ours$threshold$level, ours$threshold$se),
          c(level(x), se * if (shape == "weibull") exp(x) else 1), paste(by, "delta method", sep = ", "), 1e-5)
  compare(study, "psychometric function: threshold, Wald interval", ours$threshold$delta_95,
          level(x + qnorm(c(0.025, 0.975)) * se), paste(by, "delta method", sep = ", "), 1e-5)
  # The threshold held at x: η = eta + slope (level − x).
  deviance_at <- function(x) {
    table$from <- table$level - x
    glm(cbind(chosen, trials - chosen) ~ 0 + from + offset(rep(eta, nrow(table))), binomial(link), table,
                         start = coef(model)[[2]], control = exact_glm)$deviance
  }
  rise <- function(x) deviance_at(x) - deviance(model) - qchisq(0.95, 1)
  bounds <- c(uniroot(rise, c(x - 4 * se, x), tol = 1e-9, extendInt = "downX")$root,
              uniroot(rise, c(x, x + 4 * se), tol = 1e-9, extendInt = "upX")$root)
  compare(study, "psychometric function: threshold, profile interval", ours$threshold$profile_95, level(bounds),
          paste(by, "stats::uniroot", sep = ", "), 1e-5)
}
